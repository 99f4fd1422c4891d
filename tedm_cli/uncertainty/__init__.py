"""How sure a verdict is: uncertain parameters of model and levels, drawn and propagated to ratios and probabilities."""
