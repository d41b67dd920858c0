/* The plant: rigid satellite, wheels and rods on an orbit in the geomagnetic field and the upper atmosphere.
 * It owns the truth: whatever is commanded, rods and wheels stay within their limits here. There is
 * place for PLANT_WHEELS wheels: one in the block `plant`, four in `plant_wheels`, which is built from this code, too.
 * SI units and radians; frames as at the ports. A function that returns false has noted a fault. */
#ifndef PLANT_H
#define PLANT_H

#include "attitude.h"
#include "environment.h"
#include "fault.h"
#include "plant_ports.h"
#include "wheel.h"

typedef struct {
    double t;       /* s */
    double R[3][3]; /* N from B */
    /* J Omega + sum l_i u_i [12], u_i the wheels' axes, N m s: what is conserved, so that no conversion adds rounding */
    double Pi[3];
    double l_w[PLANT_WHEELS];   /* N m s */
    double angle[PLANT_WHEELS]; /* of the wheels, rad; kept where one is not balanced */
    double dipole_mean[3];      /* of the rods over the last step, A m2 */
} PlantState;

/* An octagonal cylinder, eight sides and two ends, along a body axis; the normals of four sides lie along the two
 * others. Areas are times C_d/2: of a side and of an end. */
typedef struct {
    int32_t axis; /* a value of body_axis */
    Vector along; /* the same as a unit vector */
    double side, end;
    double slenderness;    /* end times its distance from the middle, minus twice the same of a side, m3 */
    Vector center_of_mass; /* from the middle, m */
} Cylinder;

/* The components along a body axis, a value of body_axis, and across it: in cyclic order, so that cross products keep. */
static inline Vector plant_along(int32_t axis, Vector v)
{
    switch (axis) {
    case PLANT_BODY_AXIS_X:
        return v;
    case PLANT_BODY_AXIS_Y:
        return (Vector){v.y, v.z, v.x};
    default:
        return (Vector){v.z, v.x, v.y};
    }
}

/* The surroundings in body axes, which follow from orbit and attitude alone. */
typedef struct {
    bool known;
    double t;
    Matrix R;
    Vector b, gravity_gradient, drag, solar; /* T, N m */
} Loads;

/* Parameters and what follows from them alone, nodes of the environment and last loads included. */
typedef struct {
    PlantParameters p;
    Body body;
    Wheel wheels[PLANT_WHEELS]; /* one that is not there has no torque and no momentum */
    int count;                  /* of the wheels that are there */
    double h_w0[PLANT_WHEELS];  /* N m s; 0 of one that is not there */
    Matrix rods_to_body;        /* columns u_i */
    Matrix R_NB0;
    Cylinder cylinder;
    Environment environment;
    Loads loads; /* the last ones asked for: a step ends, gives its outputs and goes on at one attitude */
    bool field_extrapolated;
} PlantLaw;

bool plant_check(const PlantParameters *p, Fault *f);

bool plant_check_wheels(const PlantParameters *p, Fault *f);

/* p must have passed the check. */
void plant_prepare_wheels(const PlantParameters *p, PlantLaw *plant);
void plant_prepare(const PlantParameters *p, PlantLaw *plant);

/* The state at t = 0. */
bool plant_start(const PlantLaw *plant, const PlantInputs *u, PlantState *x, Fault *f);

bool plant_outputs(PlantLaw *plant, const PlantState *x, const PlantInputs *u, PlantOutputs *y, Fault *f);

/* From t to t + h with the command held over the step. */
bool plant_step(PlantLaw *plant, PlantState *x, const PlantInputs *u, double h, PlantOutputs *y, Fault *f);

#endif
