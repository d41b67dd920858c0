/* How the rods take momentum away that the wheels cannot hold, and how much of it: docs/how/planned-wheels.md, (7). */
#ifndef CONTROLLER_PLANNED_WHEELS_SHEDDING_H
#define CONTROLLER_PLANNED_WHEELS_SHEDDING_H

#include "wheels.h"

enum { SHEDDING_NODES = 720, SHEDDING_ITERATIONS = 3 };

static const double SHEDDING_TURN = 0.01; /* rad of the orbit from node to node */
static const double SHEDDING_SOFT = 0.1;  /* |b x lambda| over |b|, below which the dipoles are less than all */
static const double SHEDDING_LEAST = 0.1; /* of `held`: less is not aimed at */

typedef struct {
    double dipole;     /* A m2, of all rods across any direction, the mean over attitudes */
    double held;       /* N m s, of which wheels bear at most so much in a turn */
    double room, turn; /* N m s, kg m2 rad: with the momentum x in the wheels a turn takes turn/(room - x) s */
} SheddingData;

typedef struct {
    Vector lambda; /* unit, in N: along it all that the rods can give */
    double time;   /* s, for which it pays to go on */
    double whole;  /* s, of that and of the turn that follows */
} Shedding;

/* The field to come, along the circle through r: that of the dipole in the Earth's middle that gives b_N here. */
typedef struct {
    Vector radial, ahead; /* unit, in N */
    Vector earth;         /* T, of the dipole over r^3 */
    double rate;          /* rad/s, of the orbit; 0: r and v are none */
} FieldAhead;

static inline FieldAhead field_ahead(Vector b_N, Vector r_N, Vector v_N)
{
    const Vector across = cross(r_N, v_N);
    const double r = norm(r_N), size = norm(across);
    FieldAhead field = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, 0.0};
    if (r > 1.0 && size > 0.0 && norm(b_N) > WHEELS_FIELD_MIN) {
        field.radial = scale(1.0 / r, r_N);
        field.ahead = cross(scale(1.0 / size, across), field.radial);
        field.earth = subtract(scale(1.5 * dot(b_N, field.radial), field.radial), b_N);
        field.rate = size / (r * r);
    }
    return field;
}

/* `angle` of the orbit further on, in N. */
static inline Vector field_at(const FieldAhead *field, double angle)
{
    const Vector up = add(scale(cos(angle), field->radial), scale(sin(angle), field->ahead));
    return subtract(scale(3.0 * dot(field->earth, up), up), field->earth);
}

/* By iterations from `before`, which is one as well, of unit length. All in N. */
static inline Shedding shedding_of(const SheddingData *data, Vector H_N, Vector before, const FieldAhead *field)
{
    if (!(field->rate > 0.0 && norm(H_N) > 0.0)) {
        return (Shedding){before, 0.0, INFINITY};
    }
    const double node = SHEDDING_TURN / field->rate; /* s */
    const double least = SHEDDING_LEAST * data->held;
    Shedding found = {before, 0.0, INFINITY};
    for (int k = 0; k < SHEDDING_ITERATIONS; ++k) {
        const Vector lambda = found.lambda;
        const Matrix none = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
        Matrix M = none, M_best = none;
        double left = dot(lambda, H_N), left_best = left, time = 0.0, whole = INFINITY;
        found.time = 0.0;
        for (int i = 0; i <= SHEDDING_NODES && time < whole; ++i) {
            const double turn = data->turn / (data->room - larger(left, 0.0));
            if (left <= data->held ? time + turn < whole : !(whole < INFINITY)) {
                whole = left <= data->held ? time + turn : INFINITY;
                M_best = M;
                left_best = clip(left, least, data->held);
                found.time = time;
            }
            if (left <= least) {
                break;
            }
            const Vector b = field_at(field, (i + 0.5) * SHEDDING_TURN);
            const double B2 = dot(b, b), sine2 = larger(B2 - dot(b, lambda) * dot(b, lambda), 0.0);
            const double most = data->dipole * node / sqrt(larger(sine2, SHEDDING_SOFT * SHEDDING_SOFT * B2));
            const double share = most * sine2 > left - 0.9 * least ? (left - 0.9 * least) / (most * sine2) : 1.0;
            M = add_scaled(M, share * most * B2, identity);
            M = add_scaled(M, -share * most, (Matrix){scale(b.x, b), scale(b.y, b), scale(b.z, b)});
            left -= share * most * sine2;
            time += share * node;
        }
        found.whole = whole;
        const Vector next = solve(add_scaled(M_best, left_best, identity), H_N);
        found.lambda = direction(norm(next), next);
    }
    return found;
}

/* Along the rods, A m2: all that takes momentum along lambda_B away, less where the field lies along it. */
static inline Vector shedding_dipole(Matrix rods, double dipole_max, const double rod_limits[3], Vector lambda_B,
                                     Vector b)
{
    const double B = norm(b);
    if (B < WHEELS_FIELD_MIN) {
        return (Vector){0.0, 0.0, 0.0};
    }
    const Vector along = apply(rods, scale(1.0 / (SHEDDING_SOFT * B), cross(lambda_B, b)));
    return (Vector){rod_limits[0] * dipole_max * clip(along.x, -1.0, 1.0),
                    rod_limits[1] * dipole_max * clip(along.y, -1.0, 1.0),
                    rod_limits[2] * dipole_max * clip(along.z, -1.0, 1.0)};
}

#endif
