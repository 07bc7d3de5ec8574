#!/usr/bin/env python3
"""Diagnoses against answers.

    tests/blind/score.py DIAGNOSES ANSWERS     prints the table and the failed cases; exit code 1 where a bar is missed

Both folders hold KIND/SEED.json: a diagnosis as `ballbar diagnose --json` prints it, an answer as the generator writes it. An
answer without a diagnosis counts as a diagnosis that names nothing.

Words:
  visible   a planted effect that leaves at least 1 um after zero offsets, ball centres and the bar's length (signal_um)
  named     what stands in `left_out`; joint_zero_offset is in every case and never wrong; what stands in
            `cannot_be_told_from` does not count as named (but on the plan of two flat circles, which shows no more)
  right     the planted effect and its joint are named: the kinds of lost motion are one class, a ripple must have the
            planted rate, a link's deviation the planted parameter. Where the entry says that it is one and the same as
            the planted one on these recordings (resemblance 1 to a part in ten thousand), it is right, too
  exact     every visible effect right, and nothing named that was not planted
"""

import json
import math
import os
import sys

VISIBLE_UM = 1.0
CLUTTER_UM = 2.0
FLOOR_TOLERANCE = 0.15  # of the noise floor that a diagnosis gives, against the true ones
THE_SAME = 0.9999  # resemblance: no recording of this plan can tell them apart
NOT_SCORED = {"time_us", "cycles_per_turn", "friction_nm", "row"}
SHAPES = {"angle": "joint angle", "velocity": "joint velocity", "torque": "joint torque", "direction": "other", "time": "time"}


def named(diagnosis):
    return [entry for entry in diagnosis.get("left_out", []) if entry["effect"] != "joint_zero_offset"]


def values(entry):
    return {p["name"]: p for p in entry.get("parameters", [])}


def the_same(planted, entry):
    """Has the entry a twin that is the planted effect, joint and parameter, and cannot be told from it?"""
    words = [planted["effect"], f"J{planted['joint']}" if planted.get("joint") else ""]
    names = [p["name"] for p in planted.get("parameters", [])]
    return any(other["resemblance"] >= THE_SAME and all(word in other["which"] for word in words)
               and (planted["effect"] != "link_geometry" or any(name in other["which"] for name in names))
               for other in entry.get("cannot_be_told_from", []))


def matches(planted, entry):
    if planted["effect"] == "link_geometry" and the_same(planted, entry):
        return True
    effects = [planted["effect"]] + planted.get("accept_effect", [])
    joints = planted.get("accept_joint", [planted.get("joint", 0)])
    if entry["effect"] not in effects or entry.get("joint", 0) not in joints:
        return False
    have = values(entry)
    want = {p["name"]: p["value"] for p in planted.get("parameters", [])}
    if entry["effect"] == "transmission_error":
        cycles = want.get("cycles_per_turn", planted.get("cycles_per_turn"))
        return "cycles_per_turn" in have and abs(have["cycles_per_turn"]["value"] - cycles) <= max(0.5, 0.01 * cycles)
    if entry["effect"] == "link_geometry":
        return any(name in have for name in want)
    if entry["effect"] == "tool_offset":  # across the tool's axis only one direction shows, a mixture of x and y
        return ("z_mm" in want) == ("z_mm" in have) or len(have) > 1
    if entry["effect"] == "not_in_catalogue":
        return entry.get("driver") == planted["driver"]
    return True


def in_class(planted, entry):
    """Is it one of those that the entry cannot be told from?"""
    joints = planted.get("accept_joint", [planted.get("joint", 0)])
    return any(other["effect"] == planted["effect"] and other.get("joint", 0) in joints
               for other in entry.get("cannot_be_told_from", []))


def pair(planted, entries, classes):
    """Which entry says each planted effect; None where none does. One entry says one effect. `classes`: a class that
    holds the effect says it too."""
    free, found = list(entries), []
    for effect in planted:
        entry = next((e for e in free if matches(effect, e)), None)
        if entry is None and classes:
            entry = next((e for e in free if in_class(effect, e)), None)
        if entry is not None:
            free.remove(entry)
        found.append(entry)
    return found, free


class Case:
    def __init__(self, name, answer, diagnosis):
        self.name, self.answer = name, answer
        self.kind = answer["kind"]
        self.failed = diagnosis is None
        self.diagnosis = diagnosis or {"verdict": "no diagnosis", "left_out": []}
        self.planted = answer["planted"]
        self.entries = named(self.diagnosis)
        self.outside = any(p["effect"] == "not_in_catalogue" for p in self.planted)
        self.found, self.extra = pair(self.planted, self.entries, answer["plan"] == "P0")

    def visible(self, least_um=VISIBLE_UM):
        return [(p, e) for p, e in zip(self.planted, self.found) if p["signal_um"] >= least_um]

    def exact(self):
        return not self.extra and all(entry for _, entry in self.visible())

    def says(self):
        def word(e):
            rate = values(e).get("cycles_per_turn")
            return e["effect"] + (str(e["joint"]) if e.get("joint") else "") + (f"@{rate['value']:g}" if rate else "")

        def planted(p):
            return word(p) + (f" {p['driver']}" if "driver" in p else "") + f" {p['signal_um']:.1f} um"

        return (f"planted: {', '.join(map(planted, self.planted)) or 'nothing'}; named: "
                f"{', '.join(map(word, self.entries)) or 'nothing'} ({self.diagnosis['verdict']})")


class Row:
    """A line of the table. `good` cases of `all`, at least or at most `bar` of them (a share), or a figure and its bar.
    Of fewer than `least` too large a share says nothing."""

    def __init__(self, what, bar, at_most=False, least=0):
        self.what, self.bar, self.at_most, self.least = what, bar, at_most, least
        self.hits, self.count, self.figure, self.bad = 0, 0, None, []

    def add(self, hit, case):
        self.hits += bool(hit)
        self.count += 1
        if bool(hit) == self.at_most and case not in self.bad:
            self.bad.append(case)

    def value(self):
        if self.figure is not None:
            return self.figure
        return self.hits / self.count if self.count else None

    def passes(self):
        value = self.value()
        if value is None:
            return True
        low, high = self.bar if isinstance(self.bar, tuple) else ((0, self.bar) if self.at_most else (self.bar, math.inf))
        return low <= value and (value <= high or self.count < self.least)

    def cells(self):
        value, share = self.value(), self.figure is None
        show = (lambda v: f"{100 * v:.4g} %") if share else (lambda v: f"{v:.3g}")
        bar = f"{show(self.bar[0])} to {show(self.bar[1])}" if isinstance(self.bar, tuple) else (
            ("<= " if self.at_most else ">= ") + show(self.bar))
        got = "no case" if value is None else f"{self.hits} of {self.count} = {show(value)}" if share else f"{show(value)} ({self.count} cases)"
        return [self.what, bar, got, "yes" if value is not None and self.passes() else "-" if value is None else "NO"]


def quantile(sorted_values, share):
    return sorted_values[min(len(sorted_values) - 1, math.ceil(share * len(sorted_values)) - 1)]


def flagged(case):
    return case.diagnosis["verdict"] in ("unknown_effect", "partly_explained") or any(case.found)


def located(case):
    planted, left = case.planted[0], case.diagnosis.get("remainder", {})
    return case.found[0] is not None or (left.get("structure") == SHAPES[planted["driver"]] and left.get("joint") == planted["joint"])


def covered(planted, entry):
    """For each parameter that both have: does the true value lie within two standard deviations?"""
    kind, truth = entry.get("kind"), planted.get("kind")
    if (kind == "load_friction") != (truth == "load_friction"):
        return []
    have, inside = values(entry), []
    if planted["effect"] == "tool_offset" and set(have) != {p["name"] for p in planted["parameters"]}:
        return []
    for p in planted["parameters"]:
        got = have.get(p["name"])
        if p["name"] in NOT_SCORED or got is None or not got.get("sd"):
            continue
        error = got["value"] - p["value"]
        if p["name"] == "phase_deg":
            error = (error + 180) % 360 - 180
        inside.append((p["name"], abs(error) <= 2 * got["sd"]))
    return inside


def table(cases):
    """Rows of the proof's table, and the coverage by effect."""
    rows, by_effect = [], {}

    def row(*args, **words):
        rows.append(Row(*args, **words))
        return rows[-1]

    for kind, right_bar, exact_bar in (("main", 0.98, 0.95), ("weak", 0.98, 0.95), ("noisy", 0.98, 0.95), ("p3", 0.98, 0.95),
                                       ("mujoco", 0.95, 0.80), ("practice", 1.0, 1.0)):
        these = [c for c in cases if c.kind == kind]
        right, exact = row(f"{kind}: right effect and joint", right_bar), row(f"{kind}: exact set", exact_bar)
        for case in these:
            for _, entry in case.visible() if not case.outside else []:
                right.add(entry, case)
            if case.visible() and not case.outside:
                exact.add(case.exact(), case)

    null = row("nothing missing: a name all the same", 0.005, at_most=True)
    held_median, held_90 = row("held out: rms over noise floor, median", 1.1, at_most=True), row("held out: rms over noise floor, 90 %", 1.3, at_most=True)
    floor = row("noise floor within 15 % of a true one", 0.90)
    flag, place = row("outside the catalogue: flagged", 0.98), row("outside the catalogue: joint and driver", 0.85)
    clutter, heavy = row("clutter 1 to 2 um: concealed effect named", 0.99), row("clutter 4 to 6 um: concealed effect named", 0.90)
    cover, slip = row("2-sigma intervals cover the truth", (0.90, 0.98), least=100), row("ball slips named as such", 0.90)
    paper, verdict = row("two flat circles: a name that they cannot show", 0.0, at_most=True), row("practice: verdict", 1.0)
    ratios = []
    for case in cases:
        if case.kind in ("null", "main", "weak", "noisy", "mujoco", "p3") and not case.planted:
            null.add(case.entries or case.failed, case)
        if case.kind == "main":
            held, given = case.diagnosis.get("held_out", {}), case.diagnosis.get("noise_floor_um")
            # Which phase a vibration has in another recording nobody can say.
            if not any(p["effect"] == "structural_vibration" for p in case.planted):
                ratios.append((held["rms_after_um"] / given if given and held.get("rms_after_um") else math.inf, case))
                floor.add(given and any(abs(given / true - 1) <= FLOOR_TOLERANCE for true in case.answer["noise_floor_um"].values()), case)
        if case.outside:
            flag.add(flagged(case), case)
            place.add(located(case), case)
        if case.kind in ("clutter", "heavy-clutter"):
            for _, entry in case.visible(CLUTTER_UM):
                (clutter if case.kind == "clutter" else heavy).add(entry, case)
        if case.kind in ("main", "slip"):
            for planted, entry in case.visible():
                if planted["effect"] == "ball_slip":
                    slip.add(entry, case)
        if case.kind == "main":
            for planted, entry in zip(case.planted, case.found):
                for name, inside in covered(planted, entry) if entry else []:
                    cover.add(inside, case)
                    of = by_effect.setdefault((planted["effect"], name), [0, 0])
                    of[0] += inside
                    of[1] += 1
        if case.kind == "p0":
            paper.add(case.extra, case)
        if case.kind == "practice":
            verdict.add(case.diagnosis["verdict"] in case.answer["accept_verdict"], case)
    ratios.sort(key=lambda r: r[0])
    if ratios:
        held_median.figure, held_90.figure = quantile([r for r, _ in ratios], 0.5), quantile([r for r, _ in ratios], 0.9)
        held_median.count = held_90.count = len(ratios)
        held_90.bad = [case for ratio, case in ratios if ratio > held_90.bar]
    return rows, by_effect


def read(diagnoses, answers):
    cases = []
    for kind in sorted(os.listdir(answers)):
        for file in sorted(os.listdir(os.path.join(answers, kind)), key=lambda f: (len(f), f)):
            with open(os.path.join(answers, kind, file)) as stream:
                answer = json.load(stream)
            answer["kind"] = kind
            try:
                with open(os.path.join(diagnoses, kind, file)) as stream:
                    diagnosis = json.load(stream)
            except (OSError, ValueError):
                diagnosis = None
            cases.append(Case(f"{kind} {file.removesuffix('.json')}", answer, diagnosis))
    return cases


def markdown(rows, by_effect):
    lines = ["| what | bar | reached | passed |", "|---|---|---|---|"]
    lines += ["| " + " | ".join(row.cells()) + " |" for row in rows if row.count]
    if by_effect:
        lines += ["", "2-sigma intervals by effect:", "", "| effect | parameter | covered |", "|---|---|---|"]
        lines += [f"| {effect} | {name} | {hits} of {count} |" for (effect, name), (hits, count) in sorted(by_effect.items())]
    lines += ["", "Cases that are not as they should be:", ""]
    bad = {}
    for row in rows:
        for case in row.bad:
            bad.setdefault(case.name, (case, []))[1].append(row.what)
    lines += [f"* {name}: {case.says()} [{'; '.join(whats)}]" for name, (case, whats) in bad.items()] or ["None."]
    return "\n".join(lines) + "\n"


def main():
    if len(sys.argv) != 3:
        print(__doc__, file=sys.stderr)
        return 2
    rows, by_effect = table(read(sys.argv[1], sys.argv[2]))
    print(markdown(rows, by_effect), end="")
    return 0 if all(row.passes() for row in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
