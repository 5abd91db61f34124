#!/usr/bin/env python3
"""From a hand's move to the picture that answers it, in the window; prints a Markdown table.

  DISPLAY=:N benches/latency.py SCENE.txt [...] [--seconds 8] [--size 1920x1080]

Build with `cargo build --release` before. Each scene is opened in a window on $DISPLAY (Xvfb serves), and a script drags
it with a move each 8 ms. p50 and p99 are those of the last 256 pictures, until the call that presents returned; the
largest pixel says how coarse they became. For a quiet machine: nothing else may run.
"""
import argparse
import json
import math
import pathlib
import subprocess
import sys

PROGRAM = pathlib.Path(__file__).resolve().parent.parent / "target/release/raybomb"
STEP_MS = 8


def script(seconds):
    lines = ["settle"]
    for i in range(int(seconds * 1000 / STEP_MS)):
        lines += [f"orbit {3 * math.cos(i / 40):.2f} {2 * math.sin(i / 50):.2f}", f"wait {STEP_MS / 1000}"]
    return "\n".join(lines + ["let-go", "settle", "quit"]) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="+", type=pathlib.Path)
    parser.add_argument("--seconds", type=float, default=8)
    parser.add_argument("--size", default="1920x1080")
    args = parser.parse_args()
    print("| scene | p50 | p99 | largest pixel |\n|---|---|---|---|")
    for scene in args.scenes:
        command = [PROGRAM, "view", scene, "--size", args.size, "--no-config", "--play-actions", "-"]
        done = subprocess.run(command, input=script(args.seconds), capture_output=True, text=True)
        if done.returncode:
            sys.exit(f"latency.py: {scene}:\n{done.stderr}")
        report = json.loads(done.stdout.splitlines()[-1])
        ms, size = report["input_ms"], report["largest_pixel"]
        print(f"| {scene.stem} | {ms['p50']:.1f} ms | {ms['p99']:.1f} ms | {size}x{size} |", flush=True)


if __name__ == "__main__":
    main()
