"""The matrices and notes of the closed loop as one linear system."""

from __future__ import annotations

from tedm_cli.contracts import DYNAMICS
from tedm_cli.errors import InputError
from tedm_cli.files.store import Reader
from tedm_cli.matrix_files.named import NamedMatrix

NOTES = (
    "tedm: the drag-free loop, closed.",
    "x' = A x + B d, y = C x + D d, time in s, SI units; names and units beside each matrix.",
    "Inputs: w_ forces and torques on the spacecraft (basic frame) and on each test mass (its frame), with their",
    "reactions; n_ noise of the read-outs; s_ accelerations that disturb the test masses. Outputs: coordinates, meas_",
    "read-outs, u_ commands, accelerations of the bodies, H1_a, H2_a of the housings, delta_g.",
    "delta_g and delta_g_full hold the second derivative of the read-outs: what enters n_TM1_x and n_TM2_x must enter",
    "nddot_TM1_x and nddot_TM2_x as its second derivative, for these two outputs alone.",
    "V: disturbances (rows: the first inputs) per kelvin of a thermal area, gravity and read-out of one temperature.",
    "The temperatures of a case are C_T, D_T of its own state space (--temperatures).",
)


def closed_loop_matrices(file: Reader) -> list[NamedMatrix]:
    """A, B, C, D and V of dynamics.h5; `InputError` where the controller is sampled."""
    if not file.has(DYNAMICS.SYSTEM_A):
        raise InputError(
            "the loop of a sampled controller has no continuous state space",
            where=str(file.path),
            hint="its spectra are exact: tedm simulate",
        )
    state, state_unit = file.strings(DYNAMICS.SYSTEM_STATE), file.strings(DYNAMICS.SYSTEM_STATE_UNIT)
    given, given_unit = file.strings(DYNAMICS.SYSTEM_INPUT), file.strings(DYNAMICS.SYSTEM_INPUT_UNIT)
    out, out_unit = file.strings(DYNAMICS.SYSTEM_OUTPUT), file.strings(DYNAMICS.SYSTEM_OUTPUT_UNIT)
    area = file.strings(DYNAMICS.THERMAL_AREA)
    rates = list(map("{}/s".format, state_unit))
    return [
        NamedMatrix("A", file.array(DYNAMICS.SYSTEM_A), state, state, rates, state_unit, "states by states"),
        NamedMatrix("B", file.array(DYNAMICS.SYSTEM_B), state, given, rates, given_unit, "states by inputs"),
        NamedMatrix("C", file.array(DYNAMICS.SYSTEM_C), out, state, out_unit, state_unit, "outputs by states"),
        NamedMatrix("D", file.array(DYNAMICS.SYSTEM_D), out, given, out_unit, given_unit, "outputs by inputs"),
        NamedMatrix(
            "V",
            file.array(DYNAMICS.THERMAL_V),
            file.strings(DYNAMICS.LABEL_DISTURBANCE),
            area,
            file.strings(DYNAMICS.LABEL_DISTURBANCE_UNIT),
            file.strings(DYNAMICS.THERMAL_UNIT),
            "disturbances per unit of a thermal area's temperature: S in s_, N in n_",
        ),
    ]
