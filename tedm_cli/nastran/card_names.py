"""Names of bulk data cards: which are refused, and which of those that pyNastran does not read may stand in a deck."""

from __future__ import annotations

_OTHER_TEMPERATURES = "is not read: write TEMP and TEMPD of grids, TEMPP1 of shells, TEMPRB of bars and rods"
ELEMENT_TEMPERATURES = ("TEMPP1", "TEMPRB")
"""Read by `element_temperatures`, not by pyNastran, which does not know the first and misreads lists of the second."""
_SUPERELEMENTS = "superelements are not read: solve the model in one piece"
SUPERELEMENTS = {
    *("SESET", "SEBULK", "SECONCT", "SELOC", "SEMPLN", "SEEXCLD", "SETREE", "SEBNDRY", "SELABEL", "SENQSET", "SEELT"),
    *("CSUPER", "CSUPEXT", "RELEASE", "EXTRN", "SEDLINK", "SEDRSP2", "SEDRSP3", "SESUP", "SEQSET", "SEQSET1"),
    *("SEBSET", "SEBSET1", "SECSET", "SECSET1", "SEUSET", "SEUSET1", "SELOAD", "SEQSEP"),
}
# Cards that pyNastran does not read, or that nothing here reads, and what to do about them.
REFUSED = {
    **dict.fromkeys(("TEMPP2", "TEMPP3", "TEMPB3", "TEMPN1", "TEMPF", "TEMPG", "TEMPAX"), _OTHER_TEMPERATURES),
    **dict.fromkeys(
        ("TEMPADD", "TEMPEX", "TEMPT", "TEMPBC", "TTEMP", "TMPSET"),
        "is not read: give each subcase a temperature set of its own",
    ),
    **dict.fromkeys(sorted(SUPERELEMENTS), _SUPERELEMENTS),
    "/": "deletes cards of an earlier run: a deck is read as it stands",
}
# Cards that pyNastran does not read and that touch neither linear statics nor masses nor temperatures. What changes
# stiffness, constraint, mass, load or temperature, under whatever selection, must not be here.
WITHOUT_INFLUENCE = {
    # drawn, not modelled
    *("PLOTEL3", "PLOTEL4", "PLOTEL6", "PLOTEL8", "PLOTTET", "PLOTPYR", "PLOTPEN", "PLOTHEX"),
    # sums and groups for output: monitor points, panels, sets of elements and grids
    *("MONGRP", "MONSUM", "MONSUM1", "MONSUMT", "MONCNCM", "MONCARL", "PANEL", "ERPPNL", "SET4"),
    # random response and damping of dynamic solutions
    *("RCROSS", "DAMPING", "DAMPGBL", "HYBDAMP"),
    # tables that only dynamic loads refer to
    "TABLED5",
    # design variables, responses and constraints, used by SOL 200 alone
    *("DVAR", "DSCONS", "DVSET", "DVGEOM", "DVSHAP", "DVBSHAP", "BEADVAR", "BNDGRID", "DVPSURF"),
    # aerodynamic meshes and splines, used by the aeroelastic solutions alone
    *("SPLINEX", "SPLINRB", "AEGRID", "AEQUAD4", "AETRIA3", "AEDW", "AEFORCE", "AEPRESS", "UXVEC"),
    # fatigue, computed from stresses afterwards
    *("FTGDEF", "FTGPARM", "FTGEVNT", "FTGLOAD", "FTGSEQ", "MATFTG", "PFTG", "TABLFTG"),
}
