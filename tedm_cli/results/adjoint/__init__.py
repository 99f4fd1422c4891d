"""What adjoint.h5 says, and columns of it that cases take up."""
