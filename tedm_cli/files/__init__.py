"""HDF5 and the build folder: atomic writing, checked reading, provenance; HDF5 of others. The only room with h5py."""
