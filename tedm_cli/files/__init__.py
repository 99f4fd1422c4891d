"""HDF5 and the build folder: atomic writing, checked reading, provenance. The only room that imports h5py."""
