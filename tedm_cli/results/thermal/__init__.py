"""What thermal.h5 and cases of the network say."""
