"""The usual controller of a satellite with reaction wheels, in C only: feedback of the error quaternion by the wheels,
and unloading by cross product with the rods. Its interface is fmus/interfaces/controller_wheels.toml."""
