"""Writes docs/validation.md and its plots."""
import re

from validate import fits, plot
from validate.experiment import REGISTRY

HEAD = """# Validation

Experiments whose answer is known, each under both responses where that makes sense: what theory says, what brim gives, and
how far apart they are. Written by `./dev validate` ({count} experiments, {cases} cases, {seconds:.0f} s of processor time); the quick ones
run with the tests (`Validate_NAME`). An experiment is a short function in [tools/validate/experiments](../tools/validate/experiments)
that makes its scene, beside what is read of the run, the theory and what is promised.

**{met} cases of {cases} are met.** What is missed says why. Orders are those of the error over the refined parameter, by least
squares over the logarithms.

"""


def row(outcome):
    e = outcome.experiment
    why = f"**{outcome.verdict}**" if not outcome.met or outcome.known else "met"
    if outcome.failure:
        return f"| {outcome.case.label} | {e.theory(outcome.case):.4g} | - | {outcome.failure[:80]} | {why} |"
    return f"| {outcome.case.label} | {e.theory(outcome.case):.4g} | {outcome.value:.4g} | {100 * outcome.error:+.2f} % | {why} |"


def orders(experiment, outcomes):
    """One sentence for each group of cases that differ in the studied parameter alone."""
    groups = {}
    for o in outcomes:
        rest = ", ".join(f"{k} {v}" for k, v in o.case.items() if k != experiment.study)
        if o.failure is None:
            groups.setdefault(rest, []).append((o.case[experiment.study], o.error))
    for rest, pairs in groups.items():
        p = fits.order([a for a, _ in pairs], [b for _, b in pairs])
        if p is not None:
            yield f"Order in {experiment.study}{', ' + rest if rest else ''}: {p:.1f}."


def section(experiment, outcomes, pictures):
    text = [f"### {experiment.name}", "", experiment.about, "",
            f"Theory: {experiment.law} ({experiment.source}). Promised: {100 * experiment.tolerance:g} %"
            + (f" of {experiment.scale:g} {experiment.unit}" if experiment.scale else "") + ".", "",
            f"| case | theory [{experiment.unit}] | brim | error | |", "|---|---|---|---|---|"]
    text += [row(o) for o in outcomes]
    if experiment.study:
        found = list(orders(experiment, outcomes))
        text += ["", " ".join(found)] if found else []
    for why in dict.fromkeys(o.known for o in outcomes if o.known and not o.met):
        text += ["", f"Missed: {why}"]
    lines = [(o.case.label, o.curve) for o in outcomes if o.curve][:4]
    if lines:
        case = next(o.case for o in outcomes if o.curve)
        ideal = [(x, float(experiment.ideal(case, x))) for x, _ in lines[0][1]] if experiment.ideal else []
        (pictures / f"{experiment.name}.svg").write_text(plot.svg(lines, ideal, experiment.axes), encoding="utf-8")
        text += ["", f"![{experiment.name}: {experiment.axes[1]} over {experiment.axes[0]}; dashed: theory](pictures/validation/{experiment.name}.svg)"]
    return "\n".join(text) + "\n"


def by_experiment(outcomes):
    found = {}
    for o in outcomes:
        found.setdefault(o.experiment.name, []).append(o)
    return found


def sections_of(text):
    """The sections of a page that stands, by the name of their experiment."""
    pieces = re.split(r"^### (\w+)\n", text, flags=re.MULTILINE)
    return {name: f"### {name}\n" + re.sub(r"\n## \w+\n*\Z", "\n", body).rstrip("\n") + "\n" for name, body in zip(pieces[1::2], pieces[2::2])}


def errors_of(docs):
    """{(experiment, case): error} of the page that stands."""
    page = docs / "validation.md"
    found = {}
    for name, text in sections_of(page.read_text(encoding="utf-8") if page.exists() else "").items():
        for line in text.splitlines():
            cells = [c.strip() for c in line.split("|")]
            if len(cells) == 7 and re.fullmatch(r"[-+][\d.]+ %", cells[4]):
                found[name, cells[1]] = float(cells[4][:-2]) / 100
    return found


def assemble(docs, sections, seconds):
    """The page of the given sections, in the order of the experiments; its counts are those of its rows."""
    rows = [line for text in sections.values() for line in text.splitlines() if line.startswith("| ") and not line.startswith("| case |")]
    body, group = [], None
    for name, e in REGISTRY.items():
        if name not in sections:
            continue
        kind = e.scene.__module__.rsplit(".", 1)[-1].capitalize()
        if kind != group:
            body.append(f"## {kind}\n")
            group = kind
        body.append(sections[name])
    head = HEAD.format(count=len(sections), cases=len(rows), met=sum(r.endswith("| met |") for r in rows), seconds=seconds)
    (docs / "validation.md").write_text(head + "\n".join(body), encoding="utf-8")


def write(docs, outcomes):
    """The whole page, of a run of all experiments."""
    found = by_experiment(outcomes)
    sections = {name: section(outs[0].experiment, outs, pictures_of(docs)) for name, outs in found.items()}
    assemble(docs, sections, sum(o.seconds for o in outcomes))


def update(docs, outcomes):
    """Puts the sections of some experiments, run with all their cases, in the place of those that the page has."""
    text = (docs / "validation.md").read_text(encoding="utf-8")
    sections = sections_of(text)
    for name, outs in by_experiment(outcomes).items():
        sections[name] = section(outs[0].experiment, outs, pictures_of(docs))
    assemble(docs, sections, float(re.search(r"(\d+) s of processor time", text)[1]))


def pictures_of(docs):
    folder = docs / "pictures" / "validation"
    folder.mkdir(parents=True, exist_ok=True)
    return folder
