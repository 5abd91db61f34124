#!/usr/bin/env python3
"""Camera rays: our tracer beside Embree's best mode, in turn on one pinned core; prints a Markdown table.

  RAYBOMB_PEERS=DIR RAYBOMB_SCENES=DIR benches/compare.py [SCENE.txt ...] [--rounds 5] [--threads 1]

RAYBOMB_PEERS: the folder where the program `peers` (Embree behind a command line) was set up, with its env.sh.
RAYBOMB_SCENES: a folder of scene files, used when none is named. Build with `cargo build --release` before.
Every round runs Embree, then each kernel; the table has the medians over the rounds, in Mray/s, and the ratio to the
best of Embree's modes. All at 1920x1080, one ray a pixel, no shading unless a column says so.
"""
import argparse
import json
import os
import pathlib
import statistics
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
MODES = [["--modes", "16", "--coherent", "1"], ["--modes", "8", "--coherent", "1"], ["--modes", "1"]]


def run(command, environment=None):
    done = subprocess.run(command, capture_output=True, text=True, env=environment)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, command))} failed:\n{done.stderr}")
    return [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]


def peers_environment():
    folder = os.environ.get("RAYBOMB_PEERS")
    if not folder:
        sys.exit("compare.py: set RAYBOMB_PEERS to the folder where the program `peers` was set up (it has an env.sh)")
    shell = f'. "{folder}/env.sh" && env -0'
    text = subprocess.run(["bash", "-c", shell], capture_output=True, text=True, check=True).stdout
    return dict(pair.split("=", 1) for pair in text.split("\0") if "=" in pair)


def scenes(named):
    if named:
        return named
    folder = os.environ.get("RAYBOMB_SCENES")
    if not folder:
        sys.exit("compare.py: name scene files, or set RAYBOMB_SCENES to a folder of them")
    return sorted(pathlib.Path(folder).glob("*.txt"), key=lambda p: p.stat().st_size)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--all-modes", action="store_true", help="try every mode of Embree, not only its usual best")
    options = parser.parse_args()
    environment = peers_environment()
    cores = ",".join(str(1 - i if options.threads == 1 else i) for i in range(options.threads))
    ours = ["taskset", "-c", cores, ROOT / "target/release/raybomb", "bench"]
    theirs = ["taskset", "-c", cores, "peers", "embree"]
    threads = ["--threads", str(options.threads)]
    modes = MODES if options.all_modes else MODES[:1]
    print("| scene | triangles | Embree | SSE | AVX2 | AVX-512 | ratios | shaded, AVX-512 |\n|---|---|---|---|---|---|---|---|")
    for scene in scenes(options.scenes):
        embree, mine, shaded = [], {"sse4": [], "avx2": [], "avx512": []}, []
        for _ in range(options.rounds):
            work = ["--work", "primary", "--quality", "med", "--robust", "0", "--orders", "tile"]
            embree.append(max(run([*theirs, scene, *threads, *m, *work], environment)[0]["mrays_s"] for m in modes))
            for kernel, figures in mine.items():
                row = run([*ours, scene, *threads, "--kernel", kernel, "--frames", "9", "--json"])[0]
                figures.append(row["mrays_s"])
            row = run([*ours, scene, *threads, "--workload", "shaded", "--frames", "9", "--json"])[0]
            shaded.append(row["mrays_s"])
        base = statistics.median(embree)
        middle = [statistics.median(figures) for figures in mine.values()]
        ratios = " / ".join(f"{m / base:.1f}" for m in middle)
        cells = " | ".join(f"{m:.0f}" for m in middle)
        name = pathlib.Path(scene).stem
        print(f"| {name} | {row['triangles']:,} | {base:.0f} | {cells} | {ratios} | {statistics.median(shaded):.0f} |", flush=True)


main()
