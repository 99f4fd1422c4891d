"""What files say of the field of the satellite on its test masses, and of what balances it."""
