# SPDX-License-Identifier: GPL-3.0-or-later
"""Many random scenes: ``python -m tests.fuzz --count 2000 [--first SEED] [--kind core|blender|files]``.

They run in a child process, so that a crash is one failing seed and the rest goes on. One seed alone is
``--first SEED --count 1``; it prints the traceback.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import time
import traceback
from collections import Counter

from .kinds import KINDS

CHILD_SECONDS = 120  # of the processor, for one seed


def main():
    """Run the seeds; the exit code is 1 where one failed."""
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=2000)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--kind", choices=KINDS, default="core")
    parser.add_argument("--child", action="store_true", help=argparse.SUPPRESS)
    args = parser.parse_args()
    seeds = range(args.first, args.first + args.count)
    if args.child:
        return _child(args.kind, seeds)
    started = time.perf_counter()
    failed = {}
    for seed, words in _outcomes(args.kind, seeds):
        if words:
            failed[seed] = words
            print(f"{args.kind} seed {seed}: {words}", flush=True)
    seconds = time.perf_counter() - started
    print(f"{len(seeds)} scenes of kind '{args.kind}' in {seconds:.0f} s; {len(failed)} failed: {sorted(failed)}")
    for words, count in Counter(failed.values()).most_common():
        print(f"{count:6d}  {words}")
    return 1 if failed else 0


def _outcomes(kind, seeds):
    """Yield (seed, "" or what went wrong); a child that dies fails the seed it was at."""
    at, stop = seeds.start, seeds.stop
    while at < stop:
        command = [sys.executable, "-m", "tests.fuzz", "--child", "--kind", kind]
        command += ["--first", str(at), "--count", str(stop - at)]
        errors = None if len(seeds) == 1 else subprocess.DEVNULL
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=errors, text=True) as child:
            for line in child.stdout:
                word, _, rest = line.partition(" ")
                if word == "@done":
                    seed, _, words = rest.strip().partition(" ")
                    yield int(seed), words
                    at = int(seed) + 1
        if at < stop and child.returncode != 0:
            yield at, f"the process died ({child.returncode})"
            at += 1
        elif at < stop:
            yield at, "the process ended without a word"
            return


def _child(kind, seeds):
    """Run seeds here; a line for each."""
    run = KINDS[kind]
    for seed in seeds:
        words = ""
        _limit()
        try:
            run(seed)
        except Exception as error:
            traceback.print_exc()
            words = f"{type(error).__name__}: {' '.join(str(error).split())} [{_where(error)}]"
        print(f"@done {seed} {words}", flush=True)
    return 0


def _limit():
    """Let the system end this process if a seed takes for ever; time in which it is stopped does not count."""
    try:
        import resource
    except ImportError:  # not on Windows
        return
    soft = int(time.process_time()) + CHILD_SECONDS
    resource.setrlimit(resource.RLIMIT_CPU, (soft, resource.getrlimit(resource.RLIMIT_CPU)[1]))


def _where(error):
    """File and line of the package where an exception arose."""
    frames = [f for f in traceback.extract_tb(error.__traceback__) if "zraka" in f.filename]
    frames = [f for f in frames if "/tests/" not in f.filename] or frames
    return f"{frames[-1].filename.rpartition('zraka/')[2]}:{frames[-1].lineno}" if frames else "?"


if __name__ == "__main__":
    sys.exit(main())
