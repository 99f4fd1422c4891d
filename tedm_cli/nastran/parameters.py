"""Parameters with which a unit load is another one, or gives no results; and slips in the names of those we read."""

from __future__ import annotations

from tedm_cli.errors import InputError

# The values that switch them off, and what they do.
_SPOILING = {
    "INREL": (("0",), "inertia relief frees the structure from its supports"),
    "HEATSTAT": (("NO",), "the temperatures of the unit loads would be computed ones"),
    "CHECKOUT": (("NO",), "the run stops before the solution"),
    "EXTOUT": (("",), "the run makes an external superelement"),
}


def check_parameter(name: str, value: str, place: str) -> None:
    """Refuse a parameter that alters a unit load."""
    harmless, why = _SPOILING.get(name, ((value.upper(),), ""))
    if value.upper() not in harmless:
        raise InputError(f"PARAM,{name},{value}: {why}", where=place, hint="remove it from the model")


def refuse_misspelt(name: str, place: str) -> None:
    """Refuse a name that is one slip away from a parameter that is read: Nastran passes over names it does not know."""
    for read in ("WTMASS", *_SPOILING):
        if name != read and _one_slip(name, read):
            raise InputError(f"PARAM,{name} is not known here", where=place, hint=f"is it {read}, misspelt?")


def _one_slip(a: str, b: str) -> bool:
    """Whether one letter is wrong, missing or too many, or two neighbours have changed places."""
    if len(a) == len(b):
        differ = [i for i, (x, y) in enumerate(zip(a, b, strict=True)) if x != y]
        swapped = len(differ) == 2 and differ[1] == differ[0] + 1 and sorted(a) == sorted(b)
        return len(differ) == 1 or swapped
    short, long = sorted((a, b), key=len)
    return len(long) == len(short) + 1 and any(long[:i] + long[i + 1 :] == short for i in range(len(long)))
