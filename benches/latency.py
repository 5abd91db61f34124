#!/usr/bin/env python3
"""From a hand's move to the picture that answers it, in the window; prints a Markdown table.

  benches/latency.py SCENE.txt [...] [--seconds 60] [--size 1920x1080] [--idle [60]] [--first [5]] [--f3d]
                            [--json OUT]
  RAYBOMB_SCENES=DIR benches/latency.py                  # the scenes of a folder, the smallest first

Build with `cargo build --release` before. Each scene is opened in a window on $DISPLAY, or without one on an Xvfb of its
own, and a script orbits it with a move each 8 ms, from the first picture on: a better tree may still be in the making.

pictures    shown a second
missed      refreshes of a 60 Hz screen that a hand waited through and that showed nothing new
p50 p99     from the first move that a picture answers until the call that presents it returned
resolution  how many window pixels one of the picture's stood for, and in how many of 100 pictures
whole after from the last move until the picture in full resolution was shown
parsed      what it takes from the file to the triangles (--first N: the best of N)
first       from the start of the program to a whole picture on the screen (the same)
idle        seconds of processor time in 60 seconds (--idle SECONDS) in which nothing happens
F3D         what F3D takes for a picture of the same triangles (--f3d). Needs ../shared/peers/f3d_fps.py, and RAYBOMB_PEERS:
            the folder where the peers were set up, with its env.sh

For a quiet machine: nothing else may run.
"""
import argparse
import contextlib
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
PROGRAM = ROOT / "target/release/raybomb"
F3D = ROOT.parent / "shared/peers/f3d_fps.py"
STEP_MS = 8


@contextlib.contextmanager
def display(size):
    """The environment of a display: the one there is, or a new Xvfb."""
    if os.environ.get("DISPLAY"):
        yield dict(os.environ)
        return
    ends = os.pipe()
    command = ["Xvfb", "-displayfd", str(ends[1]), "-noreset", "-screen", "0", f"{size}x24"]
    try:
        server = subprocess.Popen(command, pass_fds=ends[1:], stderr=subprocess.DEVNULL)
    except FileNotFoundError:
        sys.exit("latency.py: there is neither a display ($DISPLAY) nor Xvfb")
    os.close(ends[1])
    try:
        with os.fdopen(ends[0]) as number:
            yield {**os.environ, "DISPLAY": ":" + number.readline().strip()}
    finally:
        server.terminate()
        server.wait()


def view(scene, size):
    return [PROGRAM, "view", scene, "--size", size, "--no-config", "--play-actions", "-"]


def failed(scene, errors):
    sys.exit(f"latency.py: {scene}:\n{errors}")


def orbit(scene, args, environment):
    """What the window counted while a hand moved."""
    lines = ["settle"]
    for i in range(int(args.seconds * 1000 / STEP_MS)):
        lines += [f"orbit {3 * math.cos(i / 40):.2f} {2 * math.sin(i / 50):.2f}", f"wait {STEP_MS / 1000}"]
    script = "\n".join([*lines, "let-go", "settle", "quit"]) + "\n"
    start = time.monotonic()
    done = subprocess.run(view(scene, args.size), input=script, capture_output=True, text=True, env=environment)
    if done.returncode:
        failed(scene, done.stderr)
    print(f"{scene.stem}: {time.monotonic() - start:.0f} s", file=sys.stderr)
    return json.loads(done.stdout.splitlines()[-1])["moved"]


def idle(scene, args, environment):
    """Processor seconds of a window in which nothing happens."""
    pipe = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(view(scene, args.size), env=environment, **pipe) as window:
        # The map of the work is shown when the best tree stands: nothing is built any more.
        window.stdin.write("view cost\nsettle\nview shaded\nsettle\n")
        window.stdin.flush()
        if not (window.stdout.readline() and window.stdout.readline()):
            failed(scene, window.stderr.read())
        time.sleep(1)
        before = processor_seconds(window.pid)
        time.sleep(args.idle)
        used = processor_seconds(window.pid) - before
        window.communicate("quit\n")
    return used * 60 / args.idle


def first(scene, args, environment):
    """Milliseconds from the file to triangles, and from the start of the program to the first picture."""
    command = [PROGRAM, "bench", scene, "--workload", "load", "--frames", str(args.first), "--json"]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        failed(scene, done.stderr)
    shown = []
    for _ in range(args.first):
        start = time.monotonic()
        pipe = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
        with subprocess.Popen(view(scene, args.size), env=environment, **pipe) as window:
            window.stdin.write("settle\n")
            window.stdin.flush()
            if not window.stdout.readline():
                failed(scene, "it ended before there was a picture")
            shown.append(1000 * (time.monotonic() - start))
            window.communicate("quit\n")
    return {"parsed_ms": json.loads(done.stdout)["min_ms"], "first_ms": min(shown)}


def processor_seconds(pid):
    # After the program's name, in parentheses, the 12th and 13th field: ticks in the program and in the kernel.
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def words(scene):
    with scene.open() as lines:
        for line in lines:
            yield from line.partition("#")[0].split()


def triangles(scene):
    """The number of triangles, and an iterator over their numbers as text."""
    rest = words(scene)
    camera = next(rest)
    if camera == "<":
        camera += next(rest)
    for _ in range(15 if camera.lower().endswith("s") else 3):
        next(rest)
    return int(next(rest)), rest


def f3d(scene, args):
    """Milliseconds that F3D takes for a picture; `None` where it is not there."""
    folder = os.environ.get("RAYBOMB_PEERS")
    if not folder or not F3D.exists():
        print(f"latency.py: no F3D: {'set RAYBOMB_PEERS' if F3D.exists() else f'{F3D} is missing'}", file=sys.stderr)
        return None
    with tempfile.NamedTemporaryFile("w", suffix=".obj") as mesh:
        count, numbers = triangles(scene)
        for _ in range(count):
            corners = [next(numbers) for _ in range(12)]
            mesh.write("".join(f"v {' '.join(corners[i:i + 3])}\n" for i in (0, 3, 6)) + "f -3 -2 -1\n")
        mesh.flush()
        shell = f'. "{folder}/env.sh" && exec python "$@"'
        threads = {"LP_NUM_THREADS": str(os.cpu_count()), **os.environ}
        command = ["bash", "-c", shell, "python", F3D, mesh.name, "--size", args.size]
        done = subprocess.run(command, capture_output=True, text=True, env=threads)
    if done.returncode:
        print(f"latency.py: F3D on {scene}:\n{done.stderr}", file=sys.stderr)
        return None
    return 1000 / json.loads(done.stdout.splitlines()[-1])["render_fps"]


def measure(scene, args, environment):
    moved = orbit(scene, args, environment)
    return {
        "scene": scene.stem,
        "triangles": triangles(scene)[0],
        **moved,
        **(first(scene, args, environment) if args.first else {}),
        "idle_s": idle(scene, args, environment) if args.idle else None,
        "f3d_ms": f3d(scene, args) if args.f3d else None,
    }


def cells(row, args):
    pictures = row["pictures"]
    sizes = sorted((int(size), count) for size, count in row["pixel_sizes"].items())
    seconds = row["refreshes"] / 60
    ms = row["input_ms"]
    return [
        row["scene"],
        f"{row['triangles']:,}",
        f"{pictures / seconds:.0f}/s",
        f"{100 * row['missed'] / row['refreshes']:.2f} %",
        f"{ms['p50']:.1f} ms",
        f"{ms['p99']:.1f} ms",
        ", ".join(f"{size}x{size} {100 * count / pictures:.1f} %" for size, count in sizes),
        f"{row['fine_after_ms']:.0f} ms",
        *([f"{row['parsed_ms']:.0f} ms", f"{row['first_ms']:.0f} ms"] if args.first else []),
        *([f"{row['idle_s']:.2f} s"] if args.idle else []),
        *([f"{row['f3d_ms']:.0f} ms" if row["f3d_ms"] else ""] if args.f3d else []),
    ]


def scenes(named):
    if named:
        return named
    folder = os.environ.get("RAYBOMB_SCENES")
    if not folder:
        sys.exit("latency.py: name scene files, or set RAYBOMB_SCENES to a folder of them")
    return sorted(pathlib.Path(folder).glob("*.txt"), key=lambda p: p.stat().st_size)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", type=pathlib.Path)
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--size", default="1920x1080")
    parser.add_argument("--idle", nargs="?", type=float, const=60)
    parser.add_argument("--first", nargs="?", type=int, const=5)
    parser.add_argument("--f3d", action="store_true")
    parser.add_argument("--json", type=pathlib.Path, help="write all figures to this file")
    args = parser.parse_args()
    head = ["scene", "triangles", "pictures", "missed", "p50", "p99", "resolution", "whole after"]
    head += ["parsed", "first"] * bool(args.first)
    head += ["idle"] * bool(args.idle) + ["F3D"] * args.f3d
    print(f"| {' | '.join(head)} |\n|{'---|' * len(head)}")
    rows = []
    with display(args.size) as environment:
        for scene in scenes(args.scenes):
            rows.append(measure(scene, args, environment))
            print(f"| {' | '.join(cells(rows[-1], args))} |", flush=True)
    if args.json:
        args.json.write_text(json.dumps(rows, indent=1) + "\n")


if __name__ == "__main__":
    main()
