"""A scenario as a page that flies: its blocks and the step loop as WebAssembly, with sliders and faults."""
