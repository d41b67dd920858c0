"""The comparisons of tests/authorities as a page, and what the plant's integrator gains and keeps."""
