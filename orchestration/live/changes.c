/* What sets values between two steps: as in injection.py, the latest fault that acts gives an element its value, and below
 * the faults the timeline does. */
#include "live.h"

int64_t due(size_t place)
{
    const Change *it = &changes[change_order[place]];
    return (it->count + shifted[it->fault] + it->every - 1) / it->every * it->every;
}

void order_changes(void)
{
    for (size_t i = 0; i < change_count; i++) {
        change_order[i] = i;
        for (size_t k = i; k > 0 && due(k) < due(k - 1); k--) {
            const size_t later = change_order[k - 1];
            change_order[k - 1] = change_order[k];
            change_order[k] = later;
        }
    }
}

static int ended(size_t setting, size_t made)
{
    for (size_t i = 0; i < made; i++) {
        const Change *it = &changes[change_order[i]];
        if (it->kind == END && it->setting == setting) {
            return 1;
        }
    }
    return 0;
}

/* What an element is set to by the latest fault that acts after the first `made` changes; NULL where none does. */
static const double *at_fault(size_t element, size_t made)
{
    for (size_t i = made; i-- > 0;) {
        const Change *begun = &changes[change_order[i]];
        if (begun->kind != BEGIN || !acting[begun->fault] || ended(begun->setting, made)) {
            continue;
        }
        for (size_t k = 0; k < begun->value_count; k++) {
            if (begun->elements[k] == element) {
                return &begun->values[k];
            }
        }
    }
    return NULL;
}

int make_change(size_t place)
{
    const Change *change = &changes[change_order[place]];
    const Seat *seat = &seats[change->seat];
    if (!acting[change->fault]) {
        return 0;
    }
    for (size_t i = 0; i < change->get_count; i++) {
        if (failed(change->seat, get_values(seat, &change->gets[i], &change->gets[i].all))) {
            return 1;
        }
    }
    for (size_t i = 0; i < change->value_count; i++) {
        const size_t element = change->elements[i];
        if (change->kind == GIVE) {
            element_sound[element] = change->values[i];
        } else if (at_fault(element, place) == NULL) {
            element_sound[element] = element_before[element];
        }
        const double *value = at_fault(element, place + 1);
        element_given[element] = value != NULL ? *value : element_sound[element];
    }
    for (size_t i = 0; i < change->set_count; i++) {
        if (failed(change->seat, set_values(seat, &change->sets[i]))) {
            return 1;
        }
    }
    return 0;
}
