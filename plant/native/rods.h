/* The torquer rods: what each gives of its command, and when they are on. Not in the paper, whose rods always give what
 * is commanded. Period k begins at k rod_period; they are on for its share rod_duty and off for the rest. */
#ifndef PLANT_RODS_H
#define PLANT_RODS_H

#include <stdbool.h>

#include "plant_ports.h"
#include "vector.h"

typedef struct {
    double period; /* its number, an integer */
    bool on;
} Turn;

/* The turn that lasts from t on; a time within 1e-6 of a period counts as the switching instant next to it. */
Turn plant_turn_at(const PlantParameters *p, double t);

/* The duration of the turn's part in [t, t + left]: `left` where it ends no earlier. */
double plant_turn_part(const PlantParameters *p, Turn turn, double t, double left);

Turn plant_next_turn(Turn turn);

/* Along the rods, A m2. */
Vector plant_rod_dipoles(const PlantParameters *p, const PlantInputs *u, bool on);

#endif
