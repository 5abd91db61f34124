//! The few functions of Embree 4 that it takes to ask whether rays are blocked, bound when the program runs; written
//! after its public API documentation.

use std::ffi::{CString, c_char, c_void};
use std::fmt;
use std::ptr::null;
use std::time::Instant;

use glam::Vec3;
use libloading::Library;
use raybomb::scene::Scene;

/// An object of Embree's: device, geometry or scene.
type Handle = *mut c_void;

/// The largest packet.
const WIDEST: usize = 16;

/// How rays are handed over.
#[derive(Clone, Copy)]
pub struct Mode {
    /// Rays a packet: 1, 4, 8 or 16.
    width: usize,
    /// Says that they have much in common.
    coherent: bool,
}

impl Mode {
    pub fn parse(text: &str) -> Result<Mode, String> {
        let (width, coherent) = match text.strip_suffix("+coh") {
            Some(width) => (width, true),
            None => (text, false),
        };
        let width = match width {
            "i1" => 1,
            "i4" => 4,
            "i8" => 8,
            "i16" => WIDEST,
            _ => {
                return Err(format!(
                    "mode {text}: expected i1, i4, i8 or i16, perhaps with +coh"
                ));
            }
        };
        Ok(Mode { width, coherent })
    }
}

impl fmt::Display for Mode {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(
            f,
            "i{}{}",
            self.width,
            if self.coherent { "+coh" } else { "" }
        )
    }
}

/// Rays in one direction, number by number, with room for a whole packet at the end.
pub struct Rays {
    pub count: usize,
    origins: [Vec<f32>; 3],
    dir: Vec3,
}

impl Rays {
    pub fn new(dir: Vec3) -> Rays {
        Rays {
            count: 0,
            origins: Default::default(),
            dir,
        }
    }

    pub fn push(&mut self, origin: Vec3) {
        self.count += 1;
        for (numbers, number) in self.origins.iter_mut().zip(origin.to_array()) {
            numbers.push(number);
        }
    }

    pub fn finish(&mut self) {
        let padded = self.count.next_multiple_of(WIDEST);
        for numbers in &mut self.origins {
            numbers.resize(padded, 0.0);
        }
    }
}

/// `RTCRay` for N = 1, `RTCRay4`, `RTCRay8`, `RTCRay16`: each field N times.
#[repr(C, align(64))]
struct Packet<const N: usize> {
    origin: [[f32; N]; 3],
    t_near: [f32; N],
    dir: [[f32; N]; 3],
    time: [f32; N],
    t_far: [f32; N],
    mask: [u32; N],
    id: [u32; N],
    flags: [u32; N],
}

/// `RTCOccludedArguments`.
#[repr(C)]
struct Arguments {
    flags: u32,
    features: u32,
    context: *const c_void,
    filter: *const c_void,
    occluded: *const c_void,
    min_width: f32,
}

/// `int valid[N]`: −1 for the rays that count.
#[repr(C, align(64))]
struct Valid([i32; WIDEST]);

type OccludedOne = unsafe extern "C" fn(Handle, *mut c_void, *const Arguments);
type OccludedMany = unsafe extern "C" fn(*const i32, Handle, *mut c_void, *const Arguments);

/// The library and a device.
pub struct Embree {
    library: Library,
    device: Handle,
    one: OccludedOne,
    many: [OccludedMany; 3],
}

/// A scene of Embree's.
pub struct Tree<'a> {
    embree: &'a Embree,
    scene: Handle,
    pub build_s: f64,
}

// SAFETY: a committed scene may be asked by any number of threads; nothing else of it is shared.
unsafe impl Sync for Tree<'_> {}

/// A function of the library by its name and type.
///
/// # Safety
/// The type must be the one that Embree's documentation tells.
unsafe fn function<T: Copy>(library: &Library, name: &str) -> Result<T, String> {
    // SAFETY: as above.
    let symbol = unsafe { library.get::<T>(name.as_bytes()) };
    symbol.map(|f| *f).map_err(|e| format!("{name}: {e}"))
}

impl Embree {
    pub fn open(path: &str, threads: usize) -> Result<Embree, String> {
        let config = CString::new(format!("threads={threads}")).expect("no zero byte");
        // SAFETY: Embree's library runs nothing harmful when loaded; types as documented; the string outlives the call.
        unsafe {
            let library = Library::new(path).map_err(|e| format!("EMBREE_LIB: {e}"))?;
            let new_device: unsafe extern "C" fn(*const c_char) -> Handle =
                function(&library, "rtcNewDevice")?;
            let device = new_device(config.as_ptr());
            if device.is_null() {
                return Err("rtcNewDevice gave no device".to_owned());
            }
            Ok(Embree {
                one: function(&library, "rtcOccluded1")?,
                many: [
                    function(&library, "rtcOccluded4")?,
                    function(&library, "rtcOccluded8")?,
                    function(&library, "rtcOccluded16")?,
                ],
                device,
                library,
            })
        }
    }

    /// A tree over the triangles of `scene`; `quality`: `med` or `high`.
    pub fn build(&self, scene: &Scene, quality: &str) -> Result<Tree<'_>, String> {
        let quality = match quality {
            "med" => 1u32,
            "high" => 2,
            _ => return Err(format!("quality {quality}: expected med or high")),
        };
        let count = scene.triangles.len();
        let corners = || scene.triangles.iter().flat_map(|t| t.corners);
        let room = 3 * count;
        let vertices: Vec<[f32; 3]> = corners().map(|p| p.to_array()).collect();
        let indices: Vec<u32> = (0..room as u32).collect();
        const TRIANGLES: u32 = 0;
        const INDEX: (u32, u32) = (0, 0x5003);
        const VERTEX: (u32, u32) = (1, 0x9003);
        type NewBuffer = unsafe extern "C" fn(Handle, u32, u32, u32, usize, usize) -> *mut c_void;
        // SAFETY: types as documented. Buffers are Embree's own: `rtcSetNewGeometryBuffer` gives as many bytes as are
        // copied, with its own padding behind them.
        unsafe {
            let new_geometry: unsafe extern "C" fn(Handle, u32) -> Handle =
                function(&self.library, "rtcNewGeometry")?;
            let new_buffer: NewBuffer = function(&self.library, "rtcSetNewGeometryBuffer")?;
            let geometry_quality: unsafe extern "C" fn(Handle, u32) =
                function(&self.library, "rtcSetGeometryBuildQuality")?;
            let commit_geometry: unsafe extern "C" fn(Handle) =
                function(&self.library, "rtcCommitGeometry")?;
            let new_scene: unsafe extern "C" fn(Handle) -> Handle =
                function(&self.library, "rtcNewScene")?;
            let scene_quality: unsafe extern "C" fn(Handle, u32) =
                function(&self.library, "rtcSetSceneBuildQuality")?;
            let attach: unsafe extern "C" fn(Handle, Handle) -> u32 =
                function(&self.library, "rtcAttachGeometry")?;
            let release: unsafe extern "C" fn(Handle) =
                function(&self.library, "rtcReleaseGeometry")?;
            let commit: unsafe extern "C" fn(Handle) = function(&self.library, "rtcCommitScene")?;
            let error: unsafe extern "C" fn(Handle) -> u32 =
                function(&self.library, "rtcGetDeviceError")?;
            let geometry = new_geometry(self.device, TRIANGLES);
            let to = new_buffer(geometry, VERTEX.0, 0, VERTEX.1, size_of::<[f32; 3]>(), room);
            std::ptr::copy_nonoverlapping(vertices.as_ptr(), to.cast(), room);
            let to = new_buffer(geometry, INDEX.0, 0, INDEX.1, size_of::<[u32; 3]>(), count);
            std::ptr::copy_nonoverlapping(indices.as_ptr(), to.cast(), room);
            let start = Instant::now();
            geometry_quality(geometry, quality);
            commit_geometry(geometry);
            let tree = new_scene(self.device);
            scene_quality(tree, quality);
            attach(tree, geometry);
            release(geometry);
            commit(tree);
            let build_s = start.elapsed().as_secs_f64();
            match error(self.device) {
                0 => Ok(Tree {
                    embree: self,
                    scene: tree,
                    build_s,
                }),
                code => Err(format!("Embree reports error {code}")),
            }
        }
    }
}

impl Drop for Embree {
    fn drop(&mut self) {
        // SAFETY: the device is ours, and trees borrow this, so none is left.
        unsafe {
            if let Ok(release) =
                function::<unsafe extern "C" fn(Handle)>(&self.library, "rtcReleaseDevice")
            {
                release(self.device);
            }
        }
    }
}

impl Drop for Tree<'_> {
    fn drop(&mut self) {
        // SAFETY: the scene is ours and not used again.
        unsafe {
            if let Ok(release) =
                function::<unsafe extern "C" fn(Handle)>(&self.embree.library, "rtcReleaseScene")
            {
                release(self.scene);
            }
        }
    }
}

impl Tree<'_> {
    /// Whether the rays from number `first` on are blocked.
    pub fn occluded(&self, mode: Mode, rays: &Rays, first: usize, hidden: &mut [bool]) {
        match mode.width {
            1 => self.packets::<1>(mode, rays, first, hidden),
            4 => self.packets::<4>(mode, rays, first, hidden),
            8 => self.packets::<8>(mode, rays, first, hidden),
            _ => self.packets::<WIDEST>(mode, rays, first, hidden),
        }
    }

    fn packets<const N: usize>(&self, mode: Mode, rays: &Rays, first: usize, hidden: &mut [bool]) {
        let arguments = Arguments {
            flags: if mode.coherent { 1 << 16 } else { 0 },
            features: u32::MAX,
            context: null(),
            filter: null(),
            occluded: null(),
            min_width: 0.0,
        };
        let mut packet = Packet::<N> {
            origin: [[0.0; N]; 3],
            t_near: [0.0; N],
            dir: rays.dir.to_array().map(|d| [d; N]),
            time: [0.0; N],
            t_far: [0.0; N],
            mask: [u32::MAX; N],
            id: [0; N],
            flags: [0; N],
        };
        let all = Valid([-1; WIDEST]);
        for (i, hidden) in hidden.chunks_mut(N).enumerate() {
            let at = first + i * N;
            for (to, from) in packet.origin.iter_mut().zip(&rays.origins) {
                to.copy_from_slice(&from[at..at + N]);
            }
            packet.t_far = [f32::INFINITY; N];
            let some;
            let valid = if hidden.len() == N {
                &all
            } else {
                some = Valid(std::array::from_fn(|lane| {
                    if lane < hidden.len() { -1 } else { 0 }
                }));
                &some
            };
            let rays = (&raw mut packet).cast::<c_void>();
            // SAFETY: layouts as documented for N rays; both arrays are aligned to 64 bytes.
            unsafe {
                match N {
                    1 => (self.embree.one)(self.scene, rays, &arguments),
                    4 => (self.embree.many[0])(valid.0.as_ptr(), self.scene, rays, &arguments),
                    8 => (self.embree.many[1])(valid.0.as_ptr(), self.scene, rays, &arguments),
                    _ => (self.embree.many[2])(valid.0.as_ptr(), self.scene, rays, &arguments),
                }
            }
            for (hidden, t_far) in hidden.iter_mut().zip(packet.t_far) {
                *hidden = t_far < 0.0;
            }
        }
    }
}

/// Numbers too small for full precision count as 0 on this thread, as Embree's documentation asks of its callers.
pub fn flush_denormals() {
    #[cfg(target_arch = "x86_64")]
    // SAFETY: sets two bits (flush to zero, denormals are zero) of this thread's own SSE control word.
    unsafe {
        let mut word = 0u32;
        std::arch::asm!("stmxcsr [{}]", in(reg) &mut word, options(nostack));
        word |= 0x8040;
        std::arch::asm!("ldmxcsr [{}]", in(reg) &word, options(nostack));
    }
}
