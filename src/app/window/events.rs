//! What the window system and the other threads tell, passed on to what it concerns.

use std::time::Instant;

use winit::application::ApplicationHandler;
use winit::dpi::PhysicalPosition;
use winit::event::{DeviceEvent, DeviceId, ElementState, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow};
use winit::window::{Fullscreen, Window, WindowId};

use super::session::Held;
use super::{Message, Viewer, physical, report, title};
use crate::app::action::Action;
use crate::app::companion::News;
use crate::app::loader::LoadError;
use crate::app::painter::Notice;
use crate::app::screen::{Screen, Stage};
use crate::app::{AppError, backend, keys};

impl ApplicationHandler<Message> for Viewer {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        let (width, height) = self.state.size_px();
        let size = physical(width, height);
        self.memory.gives(size.into());
        let fills_screen = self.kiosk.is_some() && !self.has_own_size;
        let mut attributes = Window::default_attributes()
            .with_title(title(&self.opener))
            .with_inner_size(size)
            .with_fullscreen(fills_screen.then_some(Fullscreen::Borderless(None)));
        let screens = event_loop.available_monitors();
        let screens = screens.map(|m| (m.position().into(), m.size().into()));
        if let Some((x, y)) = self.memory.place(screens) {
            attributes = attributes.with_position(PhysicalPosition::new(x, y));
        }
        let attributes = backend::named(attributes);
        match Screen::open(event_loop, attributes) {
            Ok(screen) => {
                let size = screen.window.inner_size();
                screen.window.set_cursor_visible(self.kiosk.is_none());
                self.overlay.set_scale_factor(screen.window.scale_factor());
                self.state.set_scale_factor(screen.window.scale_factor());
                self.stage = Stage::Running(screen);
                self.resized(size);
            }
            Err(e) => self.fail(event_loop, e),
        }
    }

    fn suspended(&mut self, _event_loop: &ActiveEventLoop) {
        self.stage = Stage::Waiting;
    }

    fn user_event(&mut self, event_loop: &ActiveEventLoop, message: Message) {
        match message {
            Message::Painter(Notice::Picture(picture)) => self.take_picture(picture),
            Message::Painter(Notice::Failed(why)) => {
                self.is_awaited = false;
                self.pace.failed();
                self.picture_failed(&why);
            }
            Message::Painter(Notice::Probed(answer)) => {
                let (probe, found) = *answer;
                self.pending -= 1;
                self.state.advance(self.now());
                self.state.probed(&probe, found);
            }
            Message::Companion(side, News::Snapshot(snapshot)) => {
                self.slow.take(side, snapshot);
                self.stage.request_redraw();
                if self.to_be_saved {
                    self.save_picture();
                }
            }
            Message::Companion(side, News::Failed(why)) => {
                self.slow.take_failure(side);
                self.picture_failed(&why);
            }
            Message::Opener(heard) => self.hear(event_loop, heard),
            Message::SceneSaved(ending) => self.scene_saved(*ending),
            Message::Script(Ok(line)) => self.session.push(line),
            Message::Script(Err(why)) => self.fail(event_loop, AppError::Broken { why }),
            Message::Saved(Ok(name)) => self.tell(&format!("saved {name}")),
            Message::Saved(Err(e)) => self.tell(&format!("cannot save the picture: {e}")),
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        match event {
            // By another program, behind our back.
            WindowEvent::Destroyed => event_loop.exit(),
            WindowEvent::CloseRequested => self.act(Some(Action::Quit)),
            WindowEvent::DroppedFile(path) => self.dropped(path),
            WindowEvent::RedrawRequested => self.redraw(event_loop),
            WindowEvent::Resized(size) => self.resized(size),
            WindowEvent::Occluded(occluded) => self.occluded(occluded),
            WindowEvent::ScaleFactorChanged {
                scale_factor,
                inner_size_writer,
            } => self.rescaled(scale_factor, inner_size_writer),
            WindowEvent::Focused(false) => {
                self.hold(Held::Nothing);
                let action = self.input.focus_lost();
                self.act(Some(action));
            }
            WindowEvent::ModifiersChanged(modifiers) => {
                self.input
                    .set_modifiers(keys::modifiers_of(modifiers.state()));
            }
            WindowEvent::KeyboardInput {
                event,
                is_synthetic,
                ..
            } => self.key(&event, is_synthetic),
            WindowEvent::MouseInput { state, button, .. } => {
                if let Some(button) = keys::button_of(button) {
                    self.button(state, button);
                }
            }
            WindowEvent::CursorMoved { position, .. } => self.cursor_moved(position.x, position.y),
            WindowEvent::MouseWheel { delta, .. } => {
                let scale_factor = self
                    .stage
                    .screen()
                    .map_or(1.0, |screen| screen.window.scale_factor());
                let action = self.input.wheel(keys::notches_of(delta, scale_factor));
                self.act(action);
            }
            _ => {}
        }
    }

    fn device_event(&mut self, _: &ActiveEventLoop, _: DeviceId, event: DeviceEvent) {
        // Other systems number the buttons in other ways, and tell each notch once.
        if cfg!(not(all(unix, not(target_vendor = "apple")))) {
            return;
        }
        match event {
            DeviceEvent::Button { button, state } => {
                let is_down = state == ElementState::Pressed;
                self.input.raw_button(Some(button), is_down);
            }
            DeviceEvent::MouseMotion { .. } | DeviceEvent::MouseWheel { .. } => {
                self.input.raw_button(None, false);
            }
            _ => {}
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        self.state.advance(self.now());
        self.play_script(event_loop);
        self.obey(event_loop);
        if event_loop.exiting() {
            return;
        }
        if let Err(e) = self.opener.tick(Instant::now()) {
            report(&format!(
                "the file is not read again: {}",
                LoadError::words(&e, false)
            ));
        }
        self.note_moves();
        self.note_settled();
        let round = self.run_kiosk(event_loop);
        let due = self.order();
        let wake = [
            round,
            due,
            self.refresh_overlay(),
            self.opener.wake(Instant::now()),
            self.next_change(),
        ];
        let wake = wake.into_iter().flatten().min();
        event_loop.set_control_flow(wake.map_or(ControlFlow::Wait, ControlFlow::WaitUntil));
    }

    fn exiting(&mut self, _event_loop: &ActiveEventLoop) {
        // The surface and the window go before the connection that they live on; files are finished.
        self.stage = Stage::Waiting;
        self.saver.finish();
        for thread in self.saving.drain(..) {
            let _ = thread.join();
        }
    }
}
