"""The tests nearest to each file of the numerics, the nearest first: those that mutants of this file run."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
#: elements: motion of frames, signals, corner cases; derivatives of the whole system take longest
FORMULAS = "tests/unit/lang/test_joint_formulas.py", "tests/unit/elements/test_corners.py"
DERIVATIVES = "tests/unit/elements/test_derivatives.py"
KERNELS = (
    *FORMULAS,
    f"{DERIVATIVES}::test_kernels_at_frames",
    f"{DERIVATIVES}::test_signals_are_what_the_kernels_compute",
    f"{DERIVATIVES}::test_springs_are_gradients_of_their_energy",
    f"{DERIVATIVES}::test_dampers_take_the_power_that_their_coefficients_say",
    f"{DERIVATIVES}::test_what_replaces_springs_resists_as_they_do",
    f"{DERIVATIVES}::test_forces_and_torques_do_the_work_of_their_laws",
)
#: contacts, gears and cams against mechanics by hand, without a run: derivatives do not show a wrong size
BY_HAND = "tests/unit/elements/test_gears.py", "tests/unit/elements/test_circle_contact.py"
#: elements in space: derivatives of every kind, then motions by hand; runs of several seconds uncompiled come last
SPACE = "tests/unit/elements/test_derivatives_in_space.py"
IN_SPACE = (
    *("tests/unit/elements/test_circle_contact.py", "tests/unit/elements/test_solids_in_space.py"),
    *("tests/unit/initial/test_joint_coordinates_in_space.py", "tests/verification/test_compliant_joints_in_space.py"),
    *("tests/verification/test_gears_in_space.py", "tests/verification/test_point_on_curve_in_space.py"),
    *("tests/verification/test_screws_and_drivers_in_space.py", "tests/verification/test_friction_in_space.py"),
    *("tests/verification/test_small_motions_in_space.py", "tests/gallery/test_rolling_in_space.py"),
)
ATTITUDES = "tests/unit/system/test_attitudes.py"
ROTATIONS = "tests/unit/numerics/test_rotation.py", ATTITUDES, SPACE
SPATIAL = f"{SPACE}::test_constraint_tangents_in_a_step", f"{SPACE}::test_a_turned_scene_has_turned_forces"
PLANAR_IN_SPACE = "tests/verification/test_planar_motion_in_space.py"
STEPS_IN_SPACE = "tests/unit/simulation/test_stepping_in_space.py"
#: without the tests that solve for shapes or integrate
CABLE = (
    "tests/unit/bodies/test_cable.py",
    "-k",
    "not tip and not circle and not small_loads and not swings and not agree and not turns and not winds and not cost",
)
#: assembly of the equations, and initial values
STARTS = "tests/unit/initial/test_initial.py", "tests/unit/system/test_reductions.py"
REDUCTIONS = "tests/unit/system/test_reductions.py", "tests/unit/system/test_reductions_in_space.py"
MODES = "tests/unit/analysis/test_eigenmodes.py"
#: peaks of laws between steps; radau5 and long runs take minutes uncompiled
UNSEEN, FIXED = "tests/verification/test_unseen.py", "tests/verification/test_unseen_fixed.py"
PEAKS = (FIXED, "-k", "not radau5 and not far and not checkpoint and not hht")
INTEGRATORS = "tests/unit/integrators"
QUICK = f"{INTEGRATORS}/test_starts.py", f"{INTEGRATORS}/test_generalized_alpha.py"
#: a few steps, compared with the same equations written out in full
FULL = (f"{INTEGRATORS}/test_full_systems.py", "-k", "not test_a_step or (slider_crank and not flexible)")
CONTROL = (f"{INTEGRATORS}/test_control.py", "-k", "local_errors or bdf2 or anew or rows")
STEPS = (*CONTROL[:1], f"{INTEGRATORS}/test_run.py", "-k", f"{CONTROL[2]} or (newmark and not order)")
RADAU5 = (
    f"{INTEGRATORS}/test_radau5.py",
    "-k",
    "not test_a_step and not pieces and not statistics and not corrections",
)
RADAU = (f"{INTEGRATORS}/test_radau.py",)
BACKENDS = f"{INTEGRATORS}/test_backends.py"
JUMPS = "tests/verification/test_jumps_at_steps.py"
#: tests of a method, selected by its name; tests of its order take minutes uncompiled
METHODS = (*QUICK, FULL[0], CONTROL[0], f"{INTEGRATORS}/test_run.py", "tests/unit/simulation/test_stepping.py")
#: one run: its times, signals, saved states and parts; without runs of many seconds uncompiled
RUN = "tests/unit/simulation"
RUNS = (
    *(f"{RUN}/test_nonsense.py", f"{RUN}/test_trajectory_parts.py", f"{RUN}/test_simulation_state.py"),
    *("tests/unit/system/test_sampling.py", f"{RUN}/test_continued_runs_in_space.py"),
)
STEPPING = f"{RUN}/test_simulation_state.py", STEPS_IN_SPACE
SIMULATION = {
    "mbdsl/simulation/": RUNS,
    "mbdsl/simulation/checkpoint": (f"{RUN}/test_checkpoint.py", "-k", "damaged or pivots or no_checkpoints"),
    "mbdsl/simulation/derived_signals": ("tests/unit/system/test_sampling.py", ATTITUDES, *RUNS[1:3]),
    "mbdsl/simulation/error_growth": ("tests/unit/system/test_growth_matrices.py", f"{RUN}/test_calibration.py"),
    "mbdsl/simulation/interactive": STEPPING,
    "mbdsl/simulation/given_initial_values": (RUNS[4], "tests/unit/lang/test_given_values.py"),
    "mbdsl/simulation/large_rotations": ("tests/verification/test_free_rotation.py",),
    "mbdsl/simulation/large_tilts": ("tests/verification/test_compliant_joints_in_space.py", "-k", "half_a_turn"),
    "mbdsl/simulation/left_out_rows": ("tests/unit/explanation/test_receipt.py", *RUNS),
    "mbdsl/simulation/present_signals": STEPPING,
    "mbdsl/simulation/reader": STEPPING,
    "mbdsl/simulation/ropes_off_discs": ("tests/verification/test_ropes.py", "-k", "leaves"),
    "mbdsl/simulation/saved_state": STEPPING,
    "mbdsl/simulation/shared_friction": ("tests/verification/test_friction_in_space.py", "-k", "not_determined"),
    "mbdsl/simulation/tolerance_calibration": (f"{RUN}/test_calibration.py",),
    "mbdsl/simulation/uncertain_turns": ("tests/verification/test_space.py", "-k", "turns"),
    "mbdsl/simulation/undecided_contacts": ("tests/unit/system/test_close_approaches.py",),
    "mbdsl/simulation/fixed_step_warnings": ("tests/verification/test_doubts.py",),
    "mbdsl/simulation/run_symptoms": ("tests/verification/test_doubts.py",),
}
STUDY = "tests/unit/studies"
SWEEPS = (f"{STUDY}/test_sweep.py", "-k", "not processes and not command and not latex")
ORDERS = (f"{STUDY}/test_studies.py", "-k", "not dropped and not other_equations and not cheapest")
STUDIES = {
    "mbdsl/studies/": (f"{STUDY}/test_own_steps.py", f"{STUDY}/test_reference.py", *ORDERS),
    "mbdsl/studies/accuracy": (f"{STUDY}/test_accuracy.py", "-k", "estimate or observed or digits or compared"),
    "mbdsl/studies/cross_check": (f"{STUDY}/test_accuracy.py", "-k", "judge or outvoted or contradict or budget"),
    "mbdsl/studies/figure_parts": (f"{STUDY}/test_figure_parts.py",),
    "mbdsl/studies/families": (f"{STUDY}/test_figure_parts.py",),
    "mbdsl/studies/measures": SWEEPS,
    "mbdsl/studies/method_search": (f"{STUDY}/test_method_search.py",),
    "mbdsl/studies/recommendation": (f"{STUDY}/test_method_search.py", f"{STUDY}/test_accuracy.py"),
    "mbdsl/studies/run_order": (f"{STUDY}/test_budget.py", f"{STUDY}/test_runs.py"),
    "mbdsl/studies/runner": (f"{STUDY}/test_budget.py", f"{STUDY}/test_runs.py"),
    "mbdsl/studies/scales": (f"{STUDY}/test_accuracy.py", "-k", "rounding or rest or far or digits or difference"),
    "mbdsl/studies/slopes": (f"{STUDY}/test_slopes.py",),
    "mbdsl/studies/store": (f"{STUDY}/test_runs.py",),
    "mbdsl/studies/sweep": SWEEPS,
    "mbdsl/studies/workers": (f"{STUDY}/test_runs.py",),
}
#: beginning of a file's path -> its tests, in this order; the longest matching beginning counts
NEAREST = {
    "mbdsl/elements/": KERNELS,
    "mbdsl/elements/contact_law": BY_HAND,
    "mbdsl/elements/coordinates_in_space": (SPACE, *IN_SPACE[:3]),
    "mbdsl/elements/line_of_centres_in_space": (SPACE, "tests/verification/test_gears_in_space.py"),
    "mbdsl/elements/row": (*KERNELS, SPACE),
    "mbdsl/elements/sliding_friction": (SPACE, "tests/verification/test_friction_in_space.py"),
    "mbdsl/elements/solid": ("tests/unit/elements/test_solids_in_space.py",),
    "mbdsl/elements/swing_twist": (SPACE, "tests/verification/test_compliant_joints_in_space.py"),
    "mbdsl/elements/vectors": (SPACE, *IN_SPACE[:3]),
    "mbdsl/numerics/": STARTS,
    "mbdsl/numerics/rotation": ROTATIONS,
    "mbdsl/numerics/saddle_point": ("tests/unit/numerics/test_saddle_point.py", *STARTS),
    "mbdsl/numerics/error_norm": ("tests/unit/system/test_error_norm.py",),
    "mbdsl/numerics/tolerance": ("tests/verification/test_tolerances.py",),
    "mbdsl/numerics/hermite": ("tests/unit/simulation/test_stepping.py",),
    "mbdsl/expressions/": FORMULAS,
    "mbdsl/expressions/spatial_coordinates": (ATTITUDES, *SPATIAL),
    "mbdsl/initial/": (*STARTS, "tests/unit/explanation/test_receipt.py"),
    "mbdsl/numerics/banded": ("tests/unit/elements/test_flexible_beam.py", *CABLE),
    "mbdsl/elements/body": (
        f"{DERIVATIVES}::test_mass_and_weight",
        "tests/unit/lang/test_builder.py",
        "tests/unit/initial/test_initial.py",
        *("tests/unit/elements/test_solids_in_space.py", ATTITUDES, *SPATIAL),
    ),
    "mbdsl/bodies/ancf_cable_kernels": CABLE,
    "mbdsl/bodies/floating_beam_kernels": (
        "tests/unit/elements/test_flexible_beam.py",
        "tests/unit/bodies/test_floating.py",
    ),
    "mbdsl/bodies/floating_beam_mass": (
        "tests/unit/elements/test_flexible_beam.py",
        "tests/unit/bodies/test_floating.py",
    ),
    "mbdsl/elements/flexible_beam": ("tests/unit/elements/test_flexible_beam.py", "tests/unit/bodies/test_floating.py"),
    "mbdsl/elements/ground": (*STARTS[:1], "tests/unit/mechanism/test_graph.py", PLANAR_IN_SPACE),
    "mbdsl/elements/kind": (*KERNELS, "tests/unit/mechanism/test_graph.py", "tests/unit/explanation/test_receipt.py"),
    "mbdsl/elements/declaration": (
        *KERNELS,
        "tests/unit/mechanism/test_graph.py",
        "tests/unit/explanation/test_receipt.py",
    ),
    "mbdsl/bodies/point_mass_kernels": STARTS,
    "mbdsl/elements/point_mass": (
        *(f"{DERIVATIVES}::test_mass_and_weight", "tests/unit/mechanism/test_graph.py"),
        *("tests/verification/test_small_motions_in_space.py", IN_SPACE[5]),
    ),
    "mbdsl/bodies/rigid_body": (*STARTS, f"{DERIVATIVES}::test_signals_are_what_the_kernels_compute"),
    "mbdsl/bodies/rigid_body_kernels": (
        *KERNELS,
        FULL[0],
        "-k",
        "not test_a_step or (slider_crank and not flexible and si2)",
    ),
    "mbdsl/bodies/spatial": (*SPATIAL, f"{SPACE}::test_tangents_are_derivatives", *ROTATIONS[:2], STEPS_IN_SPACE),
    "mbdsl/elements/rod": (
        *(f"{DERIVATIVES}::test_mass_and_weight", "tests/unit/mechanism/test_graph.py"),
        *("tests/verification/test_small_motions_in_space.py", PLANAR_IN_SPACE),
    ),
    "mbdsl/elements/velocity_constraint": (*FORMULAS, "tests/unit/mechanism/test_graph.py"),
    "mbdsl/bodies/": ("tests/unit/bodies/test_floating.py", *CABLE),
    "mbdsl/bodies/ancf_cable": CABLE,
    "mbdsl/bodies/floating_beam": (
        "tests/unit/elements/test_flexible_beam.py",
        "tests/unit/bodies/test_floating.py",
    ),
    "mbdsl/system/": (*STARTS, "tests/unit/explanation/test_receipt.py"),
    "mbdsl/system/accelerations": (*STARTS, SPATIAL[1]),
    "mbdsl/system/frame_block": (SPACE,),
    "mbdsl/kernels/columns": SPATIAL,
    "mbdsl/system/gradient_rows": (*STARTS, SPACE),
    "mbdsl/system/build_tables": (*STARTS, *SPATIAL),
    "mbdsl/system/row_kernels": (*KERNELS, SPACE),
    "mbdsl/system/quaternions": ("tests/unit/system/test_reductions_in_space.py",),
    "mbdsl/system/tangents": ("tests/unit/system/test_growth_matrices.py",),
    "mbdsl/system/batch_accelerations": ("tests/unit/system/test_sampling.py",),
    "mbdsl/system/close_approaches": ("tests/unit/system/test_close_approaches.py",),
    "mbdsl/initial/counted_angles": ("tests/unit/initial/test_joint_coordinates_in_space.py", ATTITUDES),
    "mbdsl/initial/in_plane": (f"{PLANAR_IN_SPACE}::test_planar_models_in_space",),
    "mbdsl/initial/placement": ("tests/unit/initial/test_placing.py", ATTITUDES, *STARTS),
    "mbdsl/system/structure": (*STARTS, "tests/unit/system/test_emitted.py", "tests/unit/explanation/test_receipt.py"),
    "mbdsl/system/background_compilation": ("tests/unit/compilation/test_code_cache.py",),
    "mbdsl/system/body_models": STARTS,
    "mbdsl/system/time_derivatives": (
        *STARTS,
        "tests/unit/mechanism/test_reduction.py::test_accelerations_at_the_start_where_drivers_move_frames",
    ),
    "mbdsl/initial/redundancy": ("tests/unit/system/test_dependence.py",),
    "mbdsl/system/emit": (
        "tests/unit/system/test_emitted.py",
        "tests/unit/explanation/test_receipt.py",
        "tests/unit/compilation/test_code_cache.py",
    ),
    "mbdsl/system/peaks_in_fixed_steps": PEAKS,
    "mbdsl/system/nonholonomic": (
        "tests/unit/system/test_emitted.py",
        "tests/unit/system/test_reductions.py",
        f"{MODES}::test_gears",
    ),
    "mbdsl/system/index1": REDUCTIONS,
    "mbdsl/system/stabilised_index2": REDUCTIONS,
    "mbdsl/expressions/interval_arithmetic": ("tests/unit/expressions/test_intervals.py",),
    "mbdsl/expressions/interval_tables": ("tests/unit/expressions/test_intervals.py",),
    "mbdsl/system/loops": ("tests/unit/system/test_reductions.py", "tests/unit/explanation/test_receipt.py", *FULL),
    "mbdsl/system/tangent_loops": (
        "tests/unit/system/test_reductions.py",
        "tests/unit/explanation/test_receipt.py",
        *FULL,
    ),
    "mbdsl/initial/weights": (
        "tests/unit/initial/test_initial.py",
        "tests/unit/mechanism/test_reduction.py",
        "-k",
        "guess or said",
    ),
    "mbdsl/system/peaks_along_motion": ("tests/unit/expressions/test_intervals.py", *PEAKS),
    "mbdsl/system/signals": ("tests/unit/system/test_tape.py", *STARTS),
    "mbdsl/system/expression_tape": ("tests/unit/system/test_tape.py", "tests/unit/system/test_switches.py"),
    "mbdsl/system/time_events": ("tests/unit/system/test_switches.py",),
    "mbdsl/initial/undeformed": (
        "tests/unit/elements/test_flexible_beam.py",
        *STARTS,
        "tests/unit/analysis/test_eigenmodes.py",
    ),
    "mbdsl/numerics/piecewise_cubic": ("tests/unit/system/test_tape.py",),
    "mbdsl/system/system": (
        *STARTS,
        "tests/unit/explanation/test_receipt.py",
        f"{DERIVATIVES}::test_derivatives_of_the_system",
        "-k",
        "not derivatives_of or Revolute-friction",
    ),
    "mbdsl/system/switches": ("tests/unit/system/test_switches.py",),
    "mbdsl/system/peaks_in_time": ("tests/unit/expressions/test_intervals.py", *PEAKS),
    "mbdsl/integrators/": (*QUICK, *FULL),
    "mbdsl/integrators/methods/": (*QUICK, *FULL),
    "mbdsl/integrators/__init__": (BACKENDS, "-k", "registered or process"),
    "mbdsl/integrators/backends": (BACKENDS, "-k", "registered or failures or output or tolerances_of"),
    "mbdsl/integrators/methods/radau5_coefficients": RADAU5,
    "mbdsl/integrators/loop/block_lu": (f"{INTEGRATORS}/test_linear.py", *RADAU5),
    "mbdsl/integrators/loop/linear_solve": (f"{INTEGRATORS}/test_linear.py", *FULL),
    "mbdsl/integrators/loop/step_control": CONTROL,
    "mbdsl/integrators/loop/error_projection": CONTROL,
    "mbdsl/integrators/loop/split_correction": FULL,
    "mbdsl/integrators/loop/tangent_matrices": FULL,
    "mbdsl/integrators/loop/driver": STEPS,
    "mbdsl/integrators/loop/multistep": STEPS,
    "mbdsl/integrators/loop/step_times": STEPS,
    "mbdsl/integrators/events": ("tests/unit/system/test_switches.py", "tests/unit/integrators/test_events.py"),
    "mbdsl/integrators/external/": (
        BACKENDS,
        f"{UNSEEN}::test_backends_see_it",
        "-k",
        "reactions or peak or domain or see_it",
    ),
    "mbdsl/integrators/scheduled_jumps": ("tests/unit/simulation/test_stepping.py::test_reaction_behind_a_jump", JUMPS),
    "mbdsl/integrators/methods/kinematic": (
        "tests/unit/mechanism/test_reduction.py",
        "-k",
        "everything_driven or kinematics or without_reactions",
    ),
    "mbdsl/integrators/loop/zone_landing": PEAKS,
    "mbdsl/integrators/peak_zones": (UNSEEN, "-k", "nested and hht-si2-0.001"),
    "mbdsl/integrators/missed_peaks": PEAKS,
    "mbdsl/integrators/methods/radau5": RADAU5,
    "mbdsl/integrators/loop/sparse_lu": ("tests/unit/system/test_reductions.py", *FULL),
    "mbdsl/integrators/methods/radau_newton": RADAU5,
    "mbdsl/integrators/methods/radau_step": RADAU5,
    "mbdsl/integrators/methods/radau_stages": (*RADAU5, *RADAU),
    "mbdsl/integrators/methods/radau_matrices": (*RADAU5, *RADAU),
    "mbdsl/integrators/methods/radau_coefficients": RADAU,
    "mbdsl/integrators/loop/switch_location": (
        "tests/unit/system/test_switches.py",
        "tests/unit/integrators/test_events.py",
    ),
    "mbdsl/integrators/loop/turn_counting": ("tests/unit/bodies/test_turns.py",),
    "mbdsl/integrators/loop/rotation_chart": (STEPS_IN_SPACE, "tests/unit/numerics/test_rotation.py"),
    **SIMULATION,
    **STUDIES,
}


def tests_of(path: str) -> tuple[str, ...]:
    """Arguments for pytest; of a joint, a force or a method, the tests with its name alone."""
    start = max((start for start in NEAREST if path.startswith(start)), key=len)
    text = (ROOT / path).read_text(encoding="utf-8")
    made = r"^{} = (JointKind|ForceKind|in_space)\("
    plane, space = (re.search(made.format(x), text, re.MULTILINE) for x in ("KIND", "IN_SPACE"))
    stem = Path(path).stem
    kind = "".join(word.capitalize() for word in stem.split("_"))
    if start.startswith("mbdsl/elements/") and (plane or space):
        found: list[str] = [*KERNELS, f"{DERIVATIVES}::test_derivatives_of_the_system"] if plane else []
        more = [x for x in BY_HAND if kind in _text(x)] if plane else []
        if space:  # the two nearest files that have this kind: a survivor runs all of their tests
            found.append(SPACE)
            more += [x for x in IN_SPACE if re.search(rf"\b{kind}\b", _text(x))][:2]
        return (*found, *more, "-k", " or ".join([f"[{kind}", *map(_name, more)]))
    if start == "mbdsl/integrators/methods/" and re.search("^METHOD = ", text, re.MULTILINE):
        name = stem.replace("_", "-")
        return (*METHODS, "-k", f"({name} or {stem}) and not seven_body and not soft and not flexible and not order")
    return NEAREST[start]


def _text(tests: str) -> str:
    return (ROOT / tests).read_text(encoding="utf-8")


def _name(tests: str) -> str:
    """The name of a file of tests, by which ``-k`` selects all of them."""
    return Path(tests).stem
