#!/usr/bin/env python3
"""What it costs to draw over the picture: processor time of the window's own thread for a redraw with an overlay, less the
same without one, in turn; the median. Prints a Markdown table.

  benches/overlay.py [SCENE.txt] [--size 1920x1080] [--runs 40]

Build with `cargo build --release` before. Needs a window on $DISPLAY, or Xvfb, xdotool and libX11. It counts processor time, not
that of the clock: the machine need not be quiet, but a quiet one gives smaller figures.
"""
import argparse
import ctypes
import pathlib
import statistics
import subprocess
import time

from latency import PROGRAM, ROOT, display

# What draws it, and what takes it away again.
OVERLAYS = {
    "statistics": (["statistics"], ["statistics"]),
    "cross": (["axes"], ["axes"]),
    "statistics, cross, pick": (["statistics", "axes", "pick {x} {y}"], ["back", "statistics", "axes"]),
    "sheet of keys": (["sheet"], ["sheet"]),
}


class Window:
    """The program, played by a script, and a client that takes pixels from its window, so that it draws anew."""

    def __init__(self, scene, size, environment):
        command = [PROGRAM, "view", scene, "--size", size, "--no-config", "--play-actions", "-"]
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
        self.process = subprocess.Popen(command, env=environment, **pipes)
        self.settle([])
        found = subprocess.run(
            ["xdotool", "search", "--onlyvisible", "--pid", str(self.process.pid)],
            env=environment, capture_output=True, text=True, check=True,
        )
        self.window = ctypes.c_ulong(int(found.stdout.split()[-1]))
        self.xlib = ctypes.CDLL("libX11.so.6")
        self.xlib.XOpenDisplay.restype = ctypes.c_void_p
        self.display = ctypes.c_void_p(self.xlib.XOpenDisplay(environment["DISPLAY"].encode()))

    def settle(self, actions):
        self.process.stdin.write("\n".join([*actions, "settle"]) + "\n")
        self.process.stdin.flush()
        if not self.process.stdout.readline():
            raise SystemExit("overlay.py: the window is gone")

    def cost(self):
        """Milliseconds of processor time that the window's thread takes for a redraw: the mean of ten."""
        before = self.nanoseconds()
        for _ in range(10):
            self.xlib.XClearArea(self.display, self.window, 0, 0, 0, 0, 1)
            self.xlib.XSync(self.display, 0)
            # One after the other: those that wait would become one.
            time.sleep(0.01)
        return (self.nanoseconds() - before) / 10 / 1e6

    def nanoseconds(self):
        process = self.process.pid
        return int(pathlib.Path(f"/proc/{process}/task/{process}/schedstat").read_text().split()[0])

    def quit(self):
        self.process.communicate("quit\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", nargs="?", type=pathlib.Path, default=ROOT / "assets/bomb.txt")
    parser.add_argument("--size", default="1920x1080")
    parser.add_argument("--runs", type=int, default=40)
    args = parser.parse_args()
    x, y = (int(side) // 2 for side in args.size.split("x"))
    print("| over the picture | a redraw takes longer by |\n|---|---|")
    with display(args.size) as environment:
        for name, (on, off) in OVERLAYS.items():
            window = Window(args.scene, args.size, environment)
            differences = []
            for _ in range(args.runs):
                without = window.cost()
                window.settle([action.format(x=x, y=y) for action in on])
                differences.append(window.cost() - without)
                window.settle(off)
            window.quit()
            print(f"| {name} | {statistics.median(differences):.2f} ms |", flush=True)


if __name__ == "__main__":
    main()
