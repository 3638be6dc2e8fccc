#!/usr/bin/python3
"""Runs the validation suite and writes docs/validation.md: ./dev validate [NAME ...].

    ./dev validate                    all experiments, and the page with its plots
    ./dev validate incline hertz      these alone, to the screen
    ./dev validate incline --page     these alone, and their sections of the page
    ./dev validate --fast             the quick ones, to the screen
    ./dev validate --list             names

Each line: experiment, case, theory, figure, error and what is promised. Exit code 1 where an error is larger than promised and
not known to be, where a known miss holds or has grown over what docs/validation.md
tells, and where a run does not end well. Needs NumPy and h5py.
"""
import argparse
import concurrent.futures
import os
import pathlib
import sys
import threading
import traceback

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
sys.path.insert(0, str(HERE.parent))
import with_numpy  # noqa: E402

with_numpy.need("numpy", "h5py")
from validate import page  # noqa: E402
from validate.experiments import every  # noqa: E402,F401
from validate.experiment import REGISTRY  # noqa: E402
from validate.run import simulate  # noqa: E402


class Outcome:
    """What a case gave: its figure, or why there is none."""

    def __init__(self, experiment, case, told=None):
        self.experiment, self.case, self.told = experiment, case, told
        self.value = self.error = self.failure = self.curve = None
        self.seconds = 0.0

    @property
    def met(self):
        return self.failure is None and abs(self.error) <= self.experiment.tolerance

    @property
    def known(self):
        return self.experiment.miss(self.case)

    @property
    def worse(self):
        """Whether the error is larger than the page tells, by more than a tenth of it and of what is promised."""
        return self.failure is None and self.told is not None and abs(self.error) > 1.1 * abs(self.told) + 0.1 * self.experiment.tolerance

    @property
    def verdict(self):
        """met, known miss, MISSED, HOLDS where a known miss does, or WORSE where it has grown."""
        if self.met:
            return "HOLDS, and is marked as a miss" if self.known else "met"
        if not self.known:
            return "MISSED"
        return f"WORSE than the {100 * self.told:+.2f} % that docs/validation.md tells" if self.worse else "known miss"

    @property
    def expected(self):
        return self.met != bool(self.known) and not (self.known and self.worse)

    def text(self):
        e, label = self.experiment, f"{self.experiment.name:<22} {self.case.label:<38}"
        if self.failure:
            return f"{label} {self.failure} {self.verdict} {self.seconds:.1f} s"
        return (f"{label} theory {e.theory(self.case):10.5g} {e.unit:<7} found {self.value:10.5g}  error {100 * self.error:+8.3f} % "
                f"of {100 * e.tolerance:g} %  {self.verdict}  {self.seconds:.1f} s")


def examine(experiment, case, brim, out, limit, told=None):
    outcome = Outcome(experiment, case, told)
    folder = out / experiment.name / (case.label.replace(" ", "_").replace(",", "").replace("/", "_"))
    try:
        run, outcome.seconds = simulate(brim, experiment.scene(case), folder, limit)
        outcome.value = float(experiment.measure(case, run))
        outcome.error = float(experiment.error(case, outcome.value))
        if outcome.error != outcome.error:
            outcome.failure = "not a number"
        if experiment.curve:
            x, y = experiment.curve(case, run)
            outcome.curve = [(float(a), float(b)) for a, b in zip(x, y)]
        run.file.file.close()
    except Exception as error:  # an experiment that breaks is one that is missed
        outcome.failure = f"{type(error).__name__}: {error}"
        if os.environ.get("BRIM_VALIDATE_TRACE"):
            traceback.print_exc()
    return outcome


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--brim", default=str(ROOT / "build/release/brim"))
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "out/validate")
    parser.add_argument("--fast", action="store_true", help="the quick ones, which run with the tests")
    parser.add_argument("--page", action="store_true", help="write the sections of the named ones into docs/validation.md")
    parser.add_argument("--list", action="store_true", help="print the names and end")
    parser.add_argument("--only", default="", metavar="TEXT", help="cases whose description has this, as 'response penalty'")
    parser.add_argument("--jobs", type=int, default=2, help="runs at once, each on one thread")
    parser.add_argument("--limit", type=float, default=900.0, help="[s] for one run")
    options = parser.parse_args()

    unknown = [n for n in options.names if n not in REGISTRY]
    if unknown:
        sys.exit(f"no such experiment: {', '.join(unknown)}; --list says what there is")
    wanted = [REGISTRY[n] for n in options.names] or [e for e in REGISTRY.values() if e.fast or not options.fast]
    if options.list:
        print("\n".join(e.name for e in wanted))
        return 0
    said = threading.Lock()
    told = page.errors_of(ROOT / "docs")

    def look(experiment, case):
        outcome = examine(experiment, case, options.brim, options.out, options.limit, told.get((experiment.name, case.label)))
        with said:
            print(outcome.text(), flush=True)
        return outcome

    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        todo = [pool.submit(look, e, case) for e in wanted for case in e.cases if options.only in case.label]
        outcomes = [t.result() for t in todo]
    surprises = [o for o in outcomes if not o.expected]
    print(f"{len(wanted)} experiments, {len(outcomes)} cases: {sum(o.met for o in outcomes)} met, "
          f"{sum(o.expected and not o.met for o in outcomes)} known misses, {len(surprises)} unexpected, "
          f"{sum(o.seconds for o in outcomes):.0f} s of processor time")
    if not options.names and not options.fast and not options.only:
        page.write(ROOT / "docs", outcomes)
    elif options.page and not options.only:
        page.update(ROOT / "docs", outcomes)
    return 1 if surprises else 0


if __name__ == "__main__":
    sys.exit(main())
