#include "ahead.h"

#include <string.h>

#include "modes.h"
#include "two_body.h"

static const double PERIOD = 10.0; /* s, after which it is given anew */
static const double EVEN = 6.0;    /* the k-th time is as k (k + EVEN) */
static const double ECCENTRICITY_MAX = 0.8;

/* Whether the two-body motion is an ellipse that is not too thin. */
static bool is_ellipse(Vector r, Vector v, double mu)
{
    const double size = norm(r), energy = 2.0 / size - dot(v, v) / mu; /* 1/a */
    const double c = 1.0 - size * energy, s2 = dot(r, v) * dot(r, v) * energy / mu;
    return energy > 0.0 && c * c + s2 < ECCENTRICITY_MAX * ECCENTRICITY_MAX;
}

bool supervisor_look_ahead(const SupervisorLaw *law, const SupervisorInputs *u, SupervisorState *x, Fault *f)
{
    const SupervisorParameters *p = &law->p;
    const TwoBody orbit = {x->t, p->gravitational_parameter, vector(u->r_N), vector(u->v_N)};
    SupervisorAhead *ahead = &x->ahead;
    memset(ahead, 0, sizeof *ahead);
    if (x->mode == SUPERVISOR_SAFE || p->ahead_horizon <= 0.0 || !is_ellipse(orbit.r, orbit.v, orbit.mu)) {
        return true;
    }
    SupervisorState later = *x;
    SupervisorInputs then = *u;
    for (int k = 0; k < SUPERVISOR_AHEAD; ++k) {
        const double i = k + 1, last = SUPERVISOR_AHEAD, share = i * (i + EVEN) / (last * (last + EVEN));
        Vector r, v;
        Reference now = SUPERVISOR_NO_REFERENCE, to = now;
        later.t = x->t + p->ahead_horizon * share;
        two_body_at(&orbit, later.t, &r, &v);
        store(r, then.r_N);
        store(v, then.v_N);
        if (later.mode == SUPERVISOR_SLEW && later.t >= later.slew_start + later.slew.duration) {
            later.mode = later.destination;
        }
        if (!supervisor_reference_now(law, &later, &then, &now, f) ||
            !supervisor_destination(law, &later, &then, &to, f)) {
            return false;
        }
        later.kept = to.R_d;
        ahead->t[k] = later.t;
        ahead->turn[k] = rotation_log(now.R_d);
        ahead->Omega[k] = now.Omega_d;
    }
    ahead->next = x->t + PERIOD;
    return true;
}
