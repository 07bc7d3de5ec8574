"""The scorer on answers and diagnoses made by hand: it must praise what is right and find what is wrong."""

import json
import os
import subprocess
import sys
import tempfile
import unittest

import score

LAG = {"effect": "servo_lag", "joint": 3, "parameters": [{"name": "lag_ms", "value": 3.0}], "signal_um": 20.0}
PLAY = {"effect": "joint_lost_motion", "joint": 2, "kind": "backlash", "signal_um": 5.0,
        "parameters": [{"name": "width_deg", "value": 0.01}, {"name": "friction_nm", "value": 1.0}]}
RIPPLE = {"effect": "transmission_error", "joint": 1, "signal_um": 4.0,
          "parameters": [{"name": "cycles_per_turn", "value": 240}, {"name": "amplitude_deg", "value": 0.002},
                         {"name": "phase_deg", "value": 359.0}]}
FAINT = {"effect": "path_smoothing", "joint": 0, "parameters": [{"name": "time_ms", "value": 10}], "signal_um": 0.4}
BUMP = {"effect": "not_in_catalogue", "joint": 2, "driver": "angle", "parameters": [], "signal_um": 5.0}


def answer(kind, *planted, plan="PM", accept=("explained",)):
    return {"kind": kind, "plan": plan, "planted": list(planted), "accept_verdict": list(accept),
            "noise_floor_um": {"one_lap_averaged_to_400_samples": 0.75}}


def says(effect, joint, sd=0.0, **values):
    entry = {"effect": effect, "joint": joint}
    entry["parameters"] = [{"name": name, "value": value, "sd": sd} for name, value in values.items()]
    return entry


def diagnosis(*left_out, verdict="explained", after_um=0.75, **more):
    return {"verdict": verdict, "noise_floor_um": 0.75, "left_out": list(left_out), "held_out": {"rms_after_um": after_um}, **more}


def rows(*pairs):
    """The table of (answer, diagnosis) pairs, by what is measured."""
    cases = [score.Case(f"{a['kind']} {i}", a, d) for i, (a, d) in enumerate(pairs)]
    return {row.what: row for row in score.table(cases)[0]}


def hits(row):
    return (row.hits, row.count)


class NamesAndJoints(unittest.TestCase):
    def right(self, planted, *left_out):
        table = rows((answer("main", *planted), diagnosis(*left_out)))
        return hits(table["main: right effect and joint"]), hits(table["main: exact set"])

    def test_the_effect_at_its_joint_is_right(self):
        self.assertEqual(self.right([LAG], says("servo_lag", 3)), ((1, 1), (1, 1)))

    def test_the_effect_at_another_joint_is_not(self):
        self.assertEqual(self.right([LAG], says("servo_lag", 5)), ((0, 1), (0, 1)))

    def test_an_extra_name_spoils_the_set_only(self):
        self.assertEqual(self.right([LAG], says("servo_lag", 3), says("servo_lag", 4)), ((1, 1), (0, 1)))

    def test_the_same_name_twice_is_an_extra(self):
        self.assertEqual(self.right([LAG], says("servo_lag", 3), says("servo_lag", 3)), ((1, 1), (0, 1)))

    def test_zero_offsets_are_never_wrong(self):
        self.assertEqual(self.right([LAG], says("servo_lag", 3), says("joint_zero_offset", 4)), ((1, 1), (1, 1)))

    def test_kinds_of_lost_motion_are_one_class(self):
        entry = dict(says("joint_lost_motion", 2), kind="friction_windup")
        self.assertEqual(self.right([PLAY], entry), ((1, 1), (1, 1)))

    def test_a_ripple_needs_its_rate(self):
        self.assertEqual(self.right([RIPPLE], says("transmission_error", 1, cycles_per_turn=120)), ((0, 1), (0, 1)))
        self.assertEqual(self.right([RIPPLE], says("transmission_error", 1, cycles_per_turn=240)), ((1, 1), (1, 1)))

    def test_a_link_needs_its_parameter(self):
        twist = {"effect": "link_geometry", "joint": 4, "accept_joint": [4, 3], "signal_um": 9.0,
                 "parameters": [{"name": "alpha_deg", "value": 0.1}]}
        self.assertEqual(self.right([twist], says("link_geometry", 4, a_mm=0.1))[0], (0, 1))
        self.assertEqual(self.right([twist], says("link_geometry", 3, alpha_deg=0.1))[0], (1, 1))

    def test_a_link_that_is_one_and_the_same_as_another_is_right(self):
        twist = {"effect": "link_geometry", "joint": 6, "signal_um": 9.0, "parameters": [{"name": "alpha_deg", "value": 0.1}]}
        other = {"effect": "link_geometry", "joint": 6, "which": "link_geometry J6 alpha_deg", "resemblance": 1.0}
        entry = dict(says("link_geometry", 5, d_mm=0.4), cannot_be_told_from=[other])
        self.assertEqual(self.right([twist], entry), ((1, 1), (1, 1)))
        near = dict(entry, cannot_be_told_from=[dict(other, resemblance=0.99)])
        self.assertEqual(self.right([twist], near)[0], (0, 1))

    def test_what_is_too_faint_may_be_named_or_not(self):
        self.assertEqual(self.right([LAG, FAINT], says("servo_lag", 3)), ((1, 1), (1, 1)))
        self.assertEqual(self.right([LAG, FAINT], says("servo_lag", 3), says("path_smoothing", 0)), ((1, 1), (1, 1)))

    def test_a_class_does_not_name_its_members(self):
        entry = dict(says("servo_lag", 5), cannot_be_told_from=[{"effect": "servo_lag", "joint": 3}])
        self.assertEqual(self.right([LAG], entry), ((0, 1), (0, 1)))

    def test_two_flat_circles_show_no_more_than_a_class(self):
        entry = dict(says("servo_lag", 5), cannot_be_told_from=[{"effect": "servo_lag", "joint": 3}])
        what = "two flat circles: a name that they cannot show"
        self.assertTrue(rows((answer("p0", LAG, plan="P0"), diagnosis(entry)))[what].passes())
        self.assertFalse(rows((answer("p0", LAG, plan="P0"), diagnosis(says("servo_lag", 5))))[what].passes())

    def test_no_diagnosis_names_nothing(self):
        table = rows((answer("main", LAG), None))
        self.assertEqual(hits(table["main: right effect and joint"]), (0, 1))
        self.assertEqual(table["held out: rms over noise floor, median"].value(), float("inf"))


class Bars(unittest.TestCase):
    def test_one_name_in_six_hundred_is_allowed_four_are_not(self):
        quiet, loud = (answer("null"), diagnosis(verdict="nothing_missing")), (answer("null"), diagnosis(says("servo_lag", 1)))
        what = "nothing missing: a name all the same"
        self.assertTrue(rows(*[quiet] * 599, loud)[what].passes())
        table = rows(*[quiet] * 596, *[loud] * 4)
        self.assertFalse(table[what].passes())
        self.assertEqual(len(table[what].bad), 4)

    def test_held_out_median_and_ninety_percent(self):
        good, bad = (answer("main", LAG), diagnosis(says("servo_lag", 3))), (answer("main", LAG), diagnosis(after_um=1.5))
        table = rows(*[good] * 8, *[bad] * 2)
        self.assertEqual(table["held out: rms over noise floor, median"].value(), 1.0)
        self.assertEqual(table["held out: rms over noise floor, 90 %"].value(), 2.0)
        self.assertFalse(table["held out: rms over noise floor, 90 %"].passes())

    def test_a_noise_floor_that_swallows_the_gap_is_found(self):
        swollen = dict(diagnosis(after_um=3.0), noise_floor_um=3.0)
        self.assertFalse(rows((answer("main", LAG), swollen))["noise floor within 15 % of a true one"].passes())

    def test_outside_the_catalogue(self):
        flag, place = "outside the catalogue: flagged", "outside the catalogue: joint and driver"

        def two(given):
            table = rows((answer("outside", BUMP), given))
            return table[flag].passes(), table[place].passes()

        entry = says("not_in_catalogue", 2)
        self.assertEqual(two(diagnosis(dict(entry, driver="angle"), verdict="unknown_effect")), (True, True))
        self.assertEqual(two(diagnosis(dict(entry, driver="velocity"), verdict="unknown_effect")), (True, False))
        self.assertEqual(two(diagnosis(says("servo_lag", 2))), (False, False))
        self.assertEqual(two(diagnosis(verdict="partly_explained", remainder={"structure": "joint angle", "joint": 2})), (True, True))

    def test_clutter_asks_for_what_is_well_above_it(self):
        small = dict(LAG, signal_um=1.5)
        table = rows((answer("clutter", LAG, small), diagnosis(says("servo_lag", 3), says("joint_compliance", 2))))
        self.assertEqual(hits(table["clutter 1 to 2 um: concealed effect named"]), (1, 1))

    def test_intervals(self):
        what = "2-sigma intervals cover the truth"

        def covered(planted, entry):
            return hits(rows((answer("main", planted), diagnosis(entry)))[what])

        self.assertEqual(covered(LAG, says("servo_lag", 3, sd=0.1, lag_ms=3.15)), (1, 1))
        self.assertEqual(covered(LAG, says("servo_lag", 3, sd=0.1, lag_ms=3.25)), (0, 1))
        self.assertEqual(covered(RIPPLE, says("transmission_error", 1, sd=1.0, cycles_per_turn=240, phase_deg=0.5)), (1, 1))
        self.assertEqual(covered(PLAY, dict(says("joint_lost_motion", 2, sd=1.0, width_deg=0.01), kind="load_friction")), (0, 0))

    def test_intervals_may_be_too_wide_only_where_few_are_counted(self):
        wide = (answer("main", LAG), diagnosis(says("servo_lag", 3, sd=9.0, lag_ms=3.1)))
        what = "2-sigma intervals cover the truth"
        self.assertTrue(rows(*[wide] * 99)[what].passes())
        self.assertFalse(rows(*[wide] * 100)[what].passes())

    def test_a_ball_that_slipped_is_named_as_such(self):
        slip = {"effect": "ball_slip", "joint": 0, "parameters": [], "signal_um": 5.0}
        table = rows((answer("slip", slip), diagnosis(says("thermal_growth", 2))), (answer("slip", slip), diagnosis(says("ball_slip", 0))))
        self.assertEqual(hits(table["ball slips named as such"]), (1, 2))
        self.assertFalse(table["ball slips named as such"].passes())


class Program(unittest.TestCase):
    def run_on(self, given):
        with tempfile.TemporaryDirectory() as folder:
            for name, content in (("answers", answer("main", LAG)), ("diagnoses", given)):
                os.makedirs(os.path.join(folder, name, "main"))
                with open(os.path.join(folder, name, "main", "7.json"), "w") as file:
                    json.dump(content, file)
            return subprocess.run([sys.executable, score.__file__, os.path.join(folder, "diagnoses"), os.path.join(folder, "answers")],
                                  capture_output=True, text=True)

    def test_prints_the_table_and_passes(self):
        result = self.run_on(diagnosis(says("servo_lag", 3)))
        self.assertIn("| main: exact set | >= 95 % | 1 of 1 = 100 % | yes |", result.stdout)
        self.assertEqual(result.returncode, 0, result.stdout)

    def test_says_which_case_failed(self):
        result = self.run_on(diagnosis(says("servo_lag", 4)))
        self.assertIn("* main 7: planted: servo_lag3 20.0 um; named: servo_lag4 (explained)", result.stdout)
        self.assertEqual(result.returncode, 1)


if __name__ == "__main__":
    unittest.main()
