/* The begins and ends of faults that set values: as in injection.py, the latest fault that acts gives an element its value. */
#include "live.h"

/* What an element is set to by the latest fault that acts after the first `made` changes; NULL where none does. */
static const double *at_fault(size_t element, size_t made)
{
    for (size_t i = made; i-- > 0;) {
        const Change *begun = &changes[i];
        for (size_t k = 0; begun->end >= made && acting[begun->fault] && k < begun->count; k++) {
            if (begun->elements[k] == element) {
                return &begun->values[k];
            }
        }
    }
    return NULL;
}

int make_change(size_t number)
{
    const Change *change = &changes[number];
    const Seat *seat = &seats[change->seat];
    for (size_t i = 0; i < change->get_count; i++) {
        if (failed(change->seat, get_values(seat, &change->gets[i], &change->gets[i].all))) {
            return 1;
        }
    }
    for (size_t i = 0; i < change->count; i++) {
        const size_t element = change->elements[i];
        if (at_fault(element, number) == NULL) {
            element_sound[element] = element_before[element];
        }
        const double *value = at_fault(element, number + 1);
        element_given[element] = value != NULL ? *value : element_sound[element];
    }
    for (size_t i = 0; i < change->set_count; i++) {
        if (failed(change->seat, set_values(seat, &change->sets[i]))) {
            return 1;
        }
    }
    return 0;
}
