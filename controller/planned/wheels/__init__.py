"""The planned controller of a satellite with a set of wheels, in C only: the turn of least time that they can give, by
closed forms. Its interface is fmus/interfaces/controller_planned_wheels.toml; docs/how/planned-wheels.md has it."""
