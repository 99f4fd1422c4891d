"""The adjoint: outputs as nodal forces, and what the sensitivity to every temperature says of thermal areas; pure."""
