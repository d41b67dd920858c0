"""The constants of the planned controller, and on which flights (cases.py) each is swept.

File in controller/planned/native, name, what it is, groups, and by what it is multiplied where that is not FACTORS.
"""

from typing import NamedTuple

FACTORS = (0.5, 2.0)


class Constant(NamedTuple):
    """A constant; of a structure all members together."""

    file: str
    name: str
    what: str
    groups: str
    factors: tuple[float, float] = FACTORS


CONSTANTS = tuple(
    Constant(*row)
    for row in (
        ("scales.c", "STEERING_LIMIT", "momentum below which the plan takes over from the steering", "acquisition"),
        ("decide.c", "RATE_MAX", "the same as a rate: the less of the two counts", "acquisition"),
        ("decide.c", "STEERING_AGAIN", "of that momentum: steering begins again beyond it", "acquisition"),
        ("decide.c", "STEERING_DIPOLE", "dipole that the steering expects of the rods", "acquisition"),
        ("decide.c", "SEARCH_SAMPLES", "samples that a search is expected to take", "acquisition"),
        ("decide.c", "SEARCH_KEPT", "time for which its plan is kept while steering", "acquisition"),
        ("decide.c", "CHALLENGE_PERIOD", "time between two searches", "acquisition"),
        ("decide.c", "CHALLENGE_GAIN", "of the plan's time or cost, below which another is flown", "acquisition"),
        ("scales.h", "PLAN_PERIOD", "time between two renewals of a plan", "acquisition, hold"),
        ("renew.c", "ITERATIONS", "iterations of a renewed plan", "acquisition, hold"),
        ("plan.c", "URGENT_HORIZON", "horizon of a plan before the hold", "acquisition"),
        ("plan.c", "STAGE_FINE", "length of the short stages", "acquisition, hold"),
        ("plan.c", "FAST", "rotation in a stage from which it is halved", "acquisition"),
        ("plan.c", "FASTER", "the same for a quarter", "acquisition"),
        ("plan.c", "SOONER", "time for the next improvement to reach the target, over the plan's", "acquisition"),
        ("ilqr.c", "WEIGHT_BEFORE", "weight of the errors before that time", "acquisition"),
        ("cost.c", "NEAR_ANGLE", "angle of a plan that has settled", "acquisition"),
        ("cost.c", "NEAR_RATE", "rate of a plan that has settled", "acquisition"),
        ("scales.c", "WEIGHT_ANGLE", "weight of the angle", "acquisition, hold"),
        ("cost.c", "BEND", "angle at which its cost becomes linear", "acquisition, hold"),
        ("scales.c", "WEIGHT_RATE", "weight of the rate", "acquisition, hold"),
        ("scales.c", "WEIGHT_CONTROL", "weight of the controls", "acquisition, hold"),
        ("scales.c", "FINAL", "weight of the errors at the end", "acquisition, hold"),
        ("scales.c", "FINAL_WHEEL", "weight of the wheel's momentum at the end", "acquisition, hold"),
        ("scales.c", "WEIGHT_WHEEL_NEAR_LIMIT", "weight of the wheel's momentum near its limit", "acquisition, hold"),
        ("scales.c", "WHEEL_NEAR_LIMIT", "share of that limit from which it counts", "acquisition, hold"),
        ("search.c", "ITERATIONS", "iterations of a start of a search", "acquisition"),
        ("search.c", "ITERATIONS_AT_ONCE", "of them until a plan is to be sooner", "acquisition"),
        ("search.c", "STIFFNESS", "stiffness of the slews that a search starts from", "acquisition"),
        ("search.c", "DAMPING", "their damping", "acquisition"),
        ("search.c", "WHEEL_REST", "time over which their wheel comes to rest", "acquisition"),
        ("scales.c", "WEIGHT_RODS", "weight of their rods", "acquisition"),
        ("scales.c", "WEIGHT_MOTOR", "weight of their wheel", "acquisition"),
        ("ilqr.c", "TURN_MAX", "rotation in a stage from which a motion is no plan", "acquisition"),
        ("ilqr.c", "CAUTION_LEAST", "least cost of changes after an iteration without gain", "acquisition, hold"),
        ("ilqr.c", "CAUTION_MOST", "largest cost of changes", "acquisition"),
        ("ilqr.c", "CAUTION_STEP", "factor between two of them", "acquisition"),
        ("steering.c", "SPACING", "time between nodes of the field ahead", "acquisition"),
        ("steering.c", "ALIGNED_MIN", "least share of the field across the costate", "acquisition"),
        ("steering.c", "ITERATIONS", "iterations of the costate", "acquisition"),
        ("steering.c", "EXACT", "time before the end from which the dipole's direction is exact", "acquisition"),
        ("steering.c", "ALIGNED_FULL", "cosine to the wanted dipole from which a rod is at its limit", "acquisition"),
        ("steering.c", "TAPER", "time before the end from which the dipole is lessened", "acquisition"),
        ("command.c", "WHEEL_REST", "time over which the wheel comes to rest while it steers", "acquisition"),
        ("search.c", "STIFFNESS_STEP", "the same, at most, over a stage", "acquisition"),
        ("search.c", "DAMPING_STEP", "the damping, at most, over a stage", "acquisition"),
        ("ilqr.c", "GAIN_MIN", "gain of an iteration, of the cost, that is the last", "acquisition, hold"),
        ("plan.c", "HORIZON", "horizon of a plan in the hold", "hold"),
        ("plan.c", "FINE_UNTIL", "end of the short stages", "hold"),
        ("plan.c", "STAGE_COARSE", "length of the long stages", "hold"),
        ("decide.c", "SETTLED_ANGLE", "angle from which the hold begins", "hold"),
        ("decide.c", "SETTLED_RATE_TIME", "time in which the rate may turn by a radian there", "hold"),
        ("decide.c", "SETTLED_TIME", "how long both last until then", "hold"),
        ("decide.c", "LOST_ANGLE", "angle from which the hold is left", "hold, low inclination"),
        ("renew.h", "HOLD_COST", "cost of a plan that has a turn in it", "hold, low inclination"),
        ("decide.c", "STRAINED_ANGLE", "angle from which a hold is strained", "low inclination"),
        ("estimate.c", "STRAINED_WEIGHT", "of the angle's weight in a strained hold", "low inclination"),
        (
            "estimate.c",
            "STRAINED_NEAR_LIMIT",
            "share of the wheel's limit from which it counts in one",
            "low inclination",
        ),
        ("decide.c", "STRAINED_LOST", "angle from which a strained hold is left", "low inclination"),
        ("decide.c", "STRAINED_ORBITS", "how long it is settled until it is not strained", "low inclination"),
        ("scales.c", "STIFFNESS", "stiffness of the law [8]", "hold"),
        ("scales.c", "DAMPING", "its damping", "hold"),
        ("scales.c", "UNEVEN", "how even its stiffness is", "hold"),
        ("renew.c", "HOLD_ORBITS", "what a plan sees at least, in orbits", "small satellite, low inclination"),
        ("renew.c", "STAGE_LONG", "length of the stages that this takes", "small satellite"),
        ("renew.c", "LONGER_MAX", "number of these stages from which they are longer", "small satellite", (0.5, 1.4)),
        ("covariance.c", "TURN_SHARE", "error of the model by turning", "estimate"),
        ("covariance.c", "RODS_SHARE", "the same by the rods", "estimate"),
        ("identification_start.c", "REST_NOISE", "the same at rest", "estimate"),
        ("identification_start.c", "LASTS", "time for which this error stays alike", "estimate"),
        ("identification_start.c", "EXPECTED", "deviation before the flight of rate bias and disturbance", "estimate"),
        ("identification_start.c", "EXPECTED_DIPOLE", "the same of the residual dipole", "estimate"),
        ("identification_start.c", "PRODUCTS", "the same of products of inertia, over that of moments", "estimate"),
        ("identification_start.c", "BIAS_TIME", "time in which the bias of the rate may change", "estimate"),
        ("identification_start.c", "EXCESS_TIME", "time over which innovations are averaged", "estimate"),
        ("identification.c", "GATE", "deviations of an innovation that is believed", "estimate"),
        ("identification.c", "ALIKE", "mean cosine of two innovations from which the model is the cause", "estimate"),
        ("identification.c", "EXCESS_MAX", "widest variance over that given", "estimate"),
        ("identification.c", "EVIDENCE_MAX", "evidence against the estimate from which it begins anew", "estimate"),
        ("identification.h", "TRUST", "largest change of inertia and gains", "estimate, failed rods"),
        ("scales.c", "DISTURBANCE_MAX", "largest disturbance", "estimate"),
        ("scales.c", "RESIDUAL_DIPOLE_MAX", "largest residual dipole", "estimate"),
        ("estimate.c", "BIAS_TIME", "time over which the bias of the field is averaged", "estimate"),
        ("estimate.c", "BIAS_MAX", "its largest value", "estimate"),
        ("motion.c", "BIAS_FADES", "time over which it decreases in the prediction", "estimate"),
        ("friction.c", "EXPECTED", "friction of the wheel expected before the flight", "estimate"),
        ("friction.c", "NOISE", "noise of its torque", "estimate"),
        ("friction.c", "CHANGES_TIME", "time in which friction may change", "estimate"),
        ("friction.c", "SHARE_MAX", "largest friction", "estimate, failed wheel"),
        ("friction.c", "FORGETS", "time over which the noise of the momentum is averaged", "estimate, failed wheel"),
        ("friction.c", "NOISY", "share of noise from which the measurement counts less", "estimate"),
        ("friction.c", "GAIN_MIN", "least weight of a measurement of the momentum", "estimate"),
        ("friction.c", "BELIEVED", "largest change of momentum that is believed", "estimate"),
        ("friction.c", "NEAR_LIMIT", "share of the momentum's limit that is left out", "estimate, failed wheel"),
        ("rods_watch.c", "FADES", "time over which innovations are summed up", "failed rods"),
        ("rods_watch.c", "SUSPECTED", "squared deviations from which a rod is suspected", "failed rods"),
        ("rods_watch.c", "TOO_FAST", "rate above which nothing is watched", "failed rods"),
        ("rods_watch.c", "AFTER_FAST", "time after it", "failed rods"),
        ("identification_start.c", "WIDE_SPREAD", "deviation of the gains after a suspicion", "failed rods"),
        ("identification_start.c", "PAUSE", "time until rods are watched again", "failed rods"),
        ("identification.c", "WIDE_TRUST", "largest change of a gain then", "failed rods"),
        ("identification.c", "FAILED_SIGMA", "deviation of a gain that is known", "failed rods"),
        ("estimate.c", "GAIN_MIN", "gain of a dead rod", "failed rods"),
        ("sensors_watch.c", "FROZEN", "time for which an attitude that repeats is frozen", "failed sensors"),
        ("sensors_watch.c", "TURN_MIN", "turn by the rate below which it may repeat", "failed sensors"),
        ("sensors_watch.c", "NOISE", "the same in deviations of its noise", "failed sensors"),
        ("sensors_watch.c", "JUMP", "turn in a sample from which a rate is no rate", "failed sensors"),
        ("sensors_watch.c", "FIELD_FROZEN", "time for which a field that repeats is frozen", "failed sensors"),
        ("sensors_watch.c", "RESIDUAL_TIME", "time over which its residual is averaged", "failed sensors"),
        ("sensors_watch.c", "STRENGTH", "of the tolerance, which the strength must show", "failed sensors"),
        ("sensors_watch.c", "RIGHT", "of the tolerance, below which a field is used again", "failed sensors"),
        ("parameters.c", "FIELD_WRONG", "tolerance of the field", "failed sensors"),
        ("parameters.c", "LEFT_OUT", "the same for what a model of few degrees leaves out", "failed sensors"),
        ("friction.c", "MUCH", "torque from which a sample counts", "failed wheel"),
        ("friction.c", "WATCHED", "time of such samples from which a failure is known", "failed wheel"),
        ("friction.c", "FAILED", "share of the torque below which a wheel has failed", "failed wheel"),
        ("friction.c", "MOST", "torque from which a sample counts for a stuck wheel", "failed wheel", (0.5, 1.4)),
        ("friction.c", "STUCK", "share of the torque below which it is stuck", "failed wheel"),
        ("rods_alone.c", "RODS_HORIZON", "horizon and length of stages, over those chosen", "rods alone"),
        ("rods_alone.c", "RODS_FINAL", "weight of the errors at the end", "rods alone"),
        ("rods_alone.c", "RODS_WEIGHT_RATE", "weight of the rate", "rods alone"),
        ("rods_alone.c", "RODS_WEIGHT_CONTROL", "weight of the rods", "rods alone"),
        ("cost.c", "FAR", "angle from which it costs more", "rods alone"),
        ("rods_alone.c", "RODS_WEIGHT_FAR", "weight of the angle beyond it", "rods alone"),
        ("rods_alone.h", "RODS_STARTS", "starts of a search", "rods alone"),
        ("rods_alone.c", "RODS_CHALLENGED", "cost of a plan from which searches are made", "rods alone"),
        ("rods_alone.h", "RODS_SEARCH_SAMPLES", "samples that a search is expected to take", "rods alone"),
        ("search.c", "RODS_ITERATIONS", "iterations of a start", "rods alone"),
        ("rods_alone.c", "TURN_UNTIL", "latest end of a start's turn", "rods alone"),
        ("rods_alone.c", "TURN_SLOWEST", "its least rate", "rods alone"),
        ("rods_alone.c", "TURN_MORE", "range of rates above it", "rods alone"),
        ("rods_alone.c", "TURN_LARGEST", "its largest angle", "rods alone"),
        ("rods_alone.c", "RODS_STEERED", "momentum that is left to the plan", "rods alone"),
        ("rods_alone.c", "RODS_AGAIN", "momentum from which it is steered again", "rods alone"),
    )
)


def of_group(group: str) -> list[Constant]:
    """The constants that are swept on the flights of a group."""
    return [constant for constant in CONSTANTS if group in constant.groups.split(", ")]


NOT_SWEPT = {
    "rounding, and guards against a division by zero": "ANGLE_MIN EARLY NEVER PIVOT_MIN SAMPLE_EARLY STEP_MIN TINY box_qp.c:GAIN_MIN",
    "checks of inputs and parameters": "CLOSED COLLINEAR",
    "units": "LOW_ORBIT SURFACE_FIELD",
    "the table of six starts of a search": "STRAIGHT",
    "the limit of the damping for long control periods, which none of the flights has": "DAMPING_SAMPLED",
    "wheels that are as good as none": "NO_WHEEL",
    "references by the ports, of which planned.md has measurements": "CHANGE_LASTS STILL",
}
"""Why, and the constants of the controller that are not swept; with a file where others have the name."""
