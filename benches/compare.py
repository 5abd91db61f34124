#!/usr/bin/env python3
"""Our tracer beside Embree and tinybvh, in turn on pinned cores; prints a Markdown table.

  RAYBOMB_PEERS=DIR RAYBOMB_SCENES=DIR benches/compare.py [SCENE.txt ...]
      [--workload primary|shadow|bounce|random|build] [--threads 1] [--rounds 3] [--frames 15] [--realtime] [--tinybvh]

RAYBOMB_PEERS: the folder where the program `peers` (Embree and tinybvh behind a command line) was set up, with its
env.sh. RAYBOMB_SCENES: a folder of scene files, used when none is named. Build with `cargo build --release` before.

For each scene, every mode of Embree (packets of 1, 4, 8, 16, coherent or not, both orders of pixels for camera
rays, qualities medium and high) is tried once, and the fastest is measured again in every round, in turn with each of
our kernels that this CPU has. The table has the medians over the rounds in Mray/s (build: Mtri/s) and the ratios to
Embree. Pictures are 1920x1080, one ray a pixel; `shaded` is the whole picture, `primary` writes numbers and distances.
Workload shadow: the same rays on both sides, from hits on surfaces turned to the light, by the program in
benches/peers: cargo build --release --manifest-path benches/peers/Cargo.toml --target-dir target
"""
import argparse
import json
import os
import pathlib
import statistics
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
KERNELS = ["sse4", "avx2", "avx512"]


def run(command, environment=None, may_fail=False):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True, env=environment)
    if done.returncode and not may_fail:
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


def value(row, workload):
    return row["tris"] / row["build_s"] / 1e6 if workload == "build" else row["mrays_s"]


class LitPeer:
    """Embree on the rays that our workload shadow shoots, in the mode that turned out fastest."""

    def __init__(self, scene, options, pin, environment):
        program = ROOT / "target/release/lit-peers"
        if not program.exists():
            sys.exit(f"compare.py: {program} is missing; build benches/peers as told in --help")
        self.environment = environment
        self.base = [*pin, program, scene, "--threads", options.threads]
        rows = run([*self.base, "--frames", "3"], environment)
        best = max(rows, key=lambda row: row["mrays_s"])
        self.mode, self.rays = f"{best['mode']} {best['quality']}", best["rays"]
        self.again = ["--modes", best["mode"], "--quality", best["quality"]]

    def measure(self):
        return run([*self.base, *self.again], self.environment)[0]["mrays_s"]


class Peer:
    """One peer on one scene, in the mode that turned out fastest."""

    def __init__(self, name, scene, options, pin, environment):
        self.workload, self.environment = options.workload, environment
        work = "primary" if self.workload == "build" else self.workload
        self.base = [*pin, "peers", name, scene, "--threads", options.threads, "--work", work]
        quality = ["--quality", "med"] if self.workload == "build" else ["--quality", "med,high"]
        modes = ["--modes", "1,4,8,16", "--coherent", "0,1"]
        if self.workload == "build":
            modes = ["--modes", "16", "--coherent", "1"]
        elif self.workload == "primary":
            modes += ["--orders", "tile,row"]
        options = [*modes, *quality, "--robust", "0"] if name == "embree" else []
        rows = run([*self.base, *options, "--frames", "3"], environment)
        rows = [row for row in rows if row.get("workload") == work]
        if not rows:
            sys.exit(f"compare.py: {name} printed nothing for {scene}")
        best = max(rows, key=lambda row: value(row, self.workload))
        self.mode = f"{best['mode']} {best['quality']}"
        self.again = ["--quality", best["quality"], "--modes", best["mode"]]
        if name == "embree":
            packet, _, coherent = best["mode"].lstrip("i").partition("+")
            self.again[3:] = [packet, "--robust", "0"]
            if packet != "1":
                self.again += ["--coherent", "1" if coherent else "0"]
            if self.workload == "primary":
                self.mode += f" {best['order']}"
                self.again += ["--orders", best["order"]]

    def measure(self):
        rows = run([*self.base, *self.again], self.environment)
        if not rows:
            sys.exit(f"compare.py: nothing printed by {self.base} {self.again}")
        return max(value(row, self.workload) for row in rows)


def check_rays(scene, count, options, pin):
    """Both sides must shoot the same rays."""
    command = [*pin, ROOT / "target/release/raybomb", "bench", scene, "--workload", "shadow", "--frames", "1", "--json"]
    row, = run(command)
    if row["rays"] != count:
        sys.exit(f"compare.py: {scene}: we shoot {row['rays']} rays, the peer {count}; rebuild both")


def ours(scene, options, pin, workload, extra=()):
    command = [*pin, ROOT / "target/release/raybomb", "bench", scene, "--threads", options.threads]
    rows = run([*command, "--workload", workload, "--frames", options.frames, "--json", *extra], may_fail=True)
    if not rows:
        return None
    return rows[0]["mtris_s"] if workload == "build" else rows[0]["mrays_s"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*")
    parser.add_argument("--workload", default="primary", choices=["primary", "shadow", "bounce", "random", "build"])
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--frames", type=int, default=15)
    parser.add_argument("--realtime", action="store_true", help="ahead of every other process (needs the right to)")
    parser.add_argument("--tinybvh", action="store_true", help="a column for tinybvh's best mode, too")
    options = parser.parse_args()
    environment = peers_environment()
    # The peers pin their threads to the first cores; so do we.
    pin = ["taskset", "-c", ",".join(map(str, range(options.threads)))]
    if options.realtime:
        pin = ["chrt", "-f", "50", *pin]
    found = scenes(options.scenes)
    if options.workload == "build":
        columns = {"ours": ("build", ()), "coarse": ("build", ("--coarse",))}
    else:
        columns = {k: (options.workload, ("--kernel", k)) for k in KERNELS}
        columns = {k: c for k, c in columns.items() if ours(found[0], options, pin, *c) is not None}
        if options.workload == "primary":
            columns["shaded"] = ("shaded", ())
    shadow = options.workload == "shadow"
    if shadow and options.tinybvh:
        sys.exit("compare.py: tinybvh answers no any-hit rays here")
    peers = ["embree", "tinybvh"] if options.tinybvh else ["embree"]
    head = ["scene", *peers, "Embree's mode", *columns, "ratios"]
    print("| " + " | ".join(head) + " |\n|" + "---|" * len(head))
    for scene in found:
        if shadow:
            theirs = {"embree": LitPeer(scene, options, pin, environment)}
            check_rays(scene, theirs["embree"].rays, options, pin)
        else:
            theirs = {name: Peer(name, scene, options, pin, environment) for name in peers}
        figures = {name: [] for name in [*theirs, *columns]}
        for _ in range(options.rounds):
            for name, peer in theirs.items():
                figures[name].append(peer.measure())
            for name, column in columns.items():
                figures[name].append(ours(scene, options, pin, *column))
        middle = {name: statistics.median(values) for name, values in figures.items()}
        ratios = " / ".join(f"{middle[name] / middle['embree']:.1f}" for name in columns)
        cells = [pathlib.Path(scene).stem, *(f"{middle[p]:.1f}" for p in peers), theirs["embree"].mode,
                 *(f"{middle[c]:.1f}" for c in columns), ratios]
        print("| " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
