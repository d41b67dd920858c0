"""The constants that shape the plans of the planned controller: file in controller/planned/native, name, what it is."""

CONSTANTS = (
    ("scales.c", "STEERING_LIMIT", "momentum below which the plan takes over from the steering"),
    ("plan.c", "URGENT_HORIZON", "horizon of a plan before the hold"),
    ("ilqr.c", "WEIGHT_BEFORE", "weight of the errors before the time by which the target is to be reached"),
    ("plan.c", "SOONER", "that time over the one that the plan takes"),
    ("scales.c", "WEIGHT_RATE", "weight of the rate"),
    ("cost.c", "WEIGHT_ANGLE", "weight of the angle"),
    ("cost.c", "BEND", "angle at which its cost becomes linear"),
    ("scales.c", "WEIGHT_CONTROL", "weight of the controls"),
    ("search.c", "ITERATIONS", "iterations of a start of a search"),
    ("search.c", "ITERATIONS_AT_ONCE", "of them until a plan is to be sooner"),
    ("renew.c", "ITERATIONS", "iterations of a renewed plan"),
)
