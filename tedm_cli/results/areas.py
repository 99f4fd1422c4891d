"""The thermal areas as a file tells them."""

from __future__ import annotations

import numpy as np

from tedm_cli.files.store import Reader
from tedm_cli.noise.areas import AreaTable


def read_area_table(file: Reader) -> AreaTable:
    columns = {c: np.array(file.strings(f"/area/{c}")) for c in ("name", "group", "shield", "side")}
    return AreaTable(**columns, centroid_m=file.array("/area/centroid") if file.has("/area/centroid") else None)
