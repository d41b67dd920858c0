/* The parameters of the wheels: their check, and what follows from them alone. A block for one wheel has no parameter
 * for what only a set of wheels has. Tests: tests/native/test_plant_wheels.py. */
#include "plant.h"
#include "rotation.h"

#if PLANT_WHEELS > 1
#define OF_EACH(name) {name "[1]", name "[2]", name "[3]", name "[4]"}
#define WHEEL_COUNT(p) ((p)->wheels)
#define WHEEL_BREAKAWAY(p, i) ((p)->wheel_breakaway_friction[i])
#define WHEEL_GAIN(p, i) ((p)->wheel_gain[i])
#define WHEEL_PRODUCT(p, i) ((p)->wheel_dynamic_imbalance[i])
#define WHEEL_MOMENT(p, i) ((p)->wheel_static_imbalance[i])
#define WHEEL_POSITION(p, i) vector((p)->wheel_position_B[i])
#else
#define OF_EACH(name) {name}
#define WHEEL_COUNT(p) 1
#define WHEEL_BREAKAWAY(p, i) 0.0
#define WHEEL_GAIN(p, i) 1.0
#define WHEEL_PRODUCT(p, i) 0.0
#define WHEEL_MOMENT(p, i) 0.0
#define WHEEL_POSITION(p, i) ((Vector){0.0, 0.0, 0.0})
#endif

bool plant_check_wheels(const PlantParameters *p, Fault *f)
{
    static const char *const axes[PLANT_WHEELS] = OF_EACH("wheel_axis"), *const starts[PLANT_WHEELS] = OF_EACH("h_w0");
#if PLANT_WHEELS > 1
    static const char *const gains[PLANT_WHEELS] = OF_EACH("wheel_gain");
    static const char *const products[PLANT_WHEELS] = OF_EACH("wheel_dynamic_imbalance");
    if (!(p->wheels >= 0 && p->wheels <= PLANT_WHEELS)) {
        return fault(f, "wheels", p->wheels, "0 to 4");
    }
    for (int i = 0; i < p->wheels; ++i) {
        if (!(p->wheel_gain[i] >= -2.0 && p->wheel_gain[i] <= 2.0)) {
            return fault(f, gains[i], p->wheel_gain[i], "-2 to 2");
        }
        if (!(p->wheel_dynamic_imbalance[i] <= p->wheel_inertia[i])) {
            return fault(f, products[i], p->wheel_dynamic_imbalance[i], "at most wheel_inertia");
        }
    }
#endif
    for (int i = 0; i < WHEEL_COUNT(p); ++i) {
        if (!is_unit_vector(vector(p->wheel_axis[i]), axes[i], f)) {
            return false;
        }
        if (!(fabs(p->h_w0[i]) <= p->wheel_momentum_max[i])) {
            return fault(f, starts[i], p->h_w0[i], "within wheel_momentum_max");
        }
    }
    return true;
}

void plant_prepare_wheels(const PlantParameters *p, PlantLaw *plant)
{
    plant->count = WHEEL_COUNT(p);
    plant->body.unbalanced = false;
    for (int i = 0; i < PLANT_WHEELS; ++i) {
        const bool there = i < plant->count;
        plant->body.wheel_axes[i] = there ? unit_vector(vector(p->wheel_axis[i])) : (Vector){1.0, 0.0, 0.0};
        plant->h_w0[i] = there ? p->h_w0[i] : 0.0;
        plant->wheels[i] = (Wheel){.gain = 0.0};
        plant->body.imbalances[i] = (Imbalance){.inertia = 1.0};
        if (there) {
            plant->wheels[i] = (Wheel){p->wheel_momentum_max[i],
                                       p->wheel_torque_max[i],
                                       p->wheel_viscous_friction[i] / p->wheel_inertia[i],
                                       p->wheel_coulomb_friction[i],
                                       larger(WHEEL_BREAKAWAY(p, i), p->wheel_coulomb_friction[i]),
                                       WHEEL_GAIN(p, i)};
            plant->body.imbalances[i] = plant_imbalance(plant->body.wheel_axes[i], p->wheel_inertia[i],
                                                        WHEEL_PRODUCT(p, i), WHEEL_MOMENT(p, i), WHEEL_POSITION(p, i));
            plant->body.unbalanced = plant->body.unbalanced || WHEEL_PRODUCT(p, i) > 0.0 || WHEEL_MOMENT(p, i) > 0.0;
        }
    }
}
