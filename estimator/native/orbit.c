/* The orbit: propagated, and measured where what is measured is an orbit. Tests: tests/native/test_flavours.py. */
#include "onboard.h"
#include "state.h"

static const double ORBIT_OFF = 1000.0, SPEED_OFF = 10.0; /* m and m/s that a receiver is off at most */
static const double J2_LEFT = 0.02;                       /* m/s2; what an orbit of two bodies lacks */
enum { FIXES = 20 };                                      /* of one orbit that take the place of the propagated one */

static bool is_zero(const double v[3])
{
    return v[0] == 0.0 && v[1] == 0.0 && v[2] == 0.0;
}

/* Whether an orbit, r and v, is that of another, known for t s, that was propagated: without J2, and to what receivers
 * err by at most. */
static bool is_same_orbit(Vector r, Vector v, const double r_N[3], const double v_N[3], double t)
{
    return norm(subtract(r, vector(r_N))) < ORBIT_OFF + 0.5 * J2_LEFT * t * t &&
           norm(subtract(v, vector(v_N))) < SPEED_OFF + J2_LEFT * t;
}

/* Whether a measured orbit is to be used: it is that of the propagated one, or measured ones in turn are of one orbit. */
static bool is_orbit_usable(const EstimatorLaw *law, const EstimatorInputs *u, Estimate *x)
{
    Watch *w = &x->watch[SENSOR_ORBIT];
    const double *r = u->r_N_measured, *v = u->v_N_measured;
    estimator_notice(r, true, w);
    bool usable = !x->oriented || is_same_orbit(x->r_N, x->v_N, r, v, x->since_orbit);
    if (usable) {
        x->fixes = 0;
    } else {
        Vector last_r = x->fix_r_N, last_v = x->fix_v_N;
        estimator_orbit_after(x->since_fix, law->p.gravitational_parameter, law->p.j2, &last_r, &last_v);
        const int32_t more = x->fixes < FIXES ? x->fixes + 1 : FIXES;
        x->fixes = is_same_orbit(last_r, last_v, r, v, x->since_fix) ? more : 0;
        usable = x->fixes >= FIXES && !w->frozen;
        x->oriented = !usable; /* the propagated one counts no more */
    }
    w->suspect = !usable;
    x->fix_r_N = vector(r);
    x->fix_v_N = vector(v);
    x->since_fix = 0.0;
    return estimator_trusted(w);
}

void estimator_take_orbit(const EstimatorLaw *law, const EstimatorInputs *u, bool fresh, double h, Estimate *x)
{
    const EstimatorParameters *p = &law->p;
    x->since_orbit += h;
    x->since_fix += h;
    if (x->oriented && h > 0.0) {
        estimator_orbit_after(h, p->gravitational_parameter, p->j2, &x->r_N, &x->v_N);
    }
    if (fresh && !is_zero(u->r_N_measured) && is_orbit_usable(law, u, x)) {
        const bool averaged = x->oriented && p->orbit_time > 0.0;
        const double share = averaged ? x->since_orbit / (p->orbit_time + x->since_orbit) : 1.0;
        x->r_N = add(scale(1.0 - share, x->r_N), scale(share, vector(u->r_N_measured)));
        x->v_N = add(scale(1.0 - share, x->v_N), scale(share, vector(u->v_N_measured)));
        x->since_orbit = 0.0;
        x->oriented = true;
    }
}
