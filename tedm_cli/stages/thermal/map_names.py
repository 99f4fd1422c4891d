"""Whether the nodes of the map are those of the network."""

from __future__ import annotations

from collections.abc import Sequence

from tedm_cli.noise.selection import listed
from tedm_cli.results.wording import count
from tedm_cli.stages.thermal.map_nodes import near_name


def names_of_both(network: Sequence[str], mapped: Sequence[str]) -> list[str]:
    """Sentences: nodes of the map that the network has not, and nodes of the network that do not lie on the model.

    Each is sound by itself: gains do without the map, and outputs per kelvin without the network. A case of the network
    needs both, and refuses nodes of the map that are not in the network.
    """
    known, placed = set(network), set(mapped)
    notes = []
    if unknown := [name for name in mapped if name not in known]:
        which = "none" if len(unknown) == len(mapped) else f"{len(unknown)} not"
        notes.append(
            f"of the {count(len(mapped), 'node')} of the map {which} in the network, so no case can take its"
            f" temperatures: {listed(unknown)}{near_name(unknown[0], list(network))}"
        )
    if off := [name for name in network if name not in placed]:
        notes.append(f"{count(len(off), 'node')} of the network not on the model: {listed(off)}")
    return notes
