#include "table.h"

#include <string.h>

#include "record_file.h"

static const double SHORT =
    0.01; /* of a step: how much before an instant counts as that, for hosts that add up times */

static bool sound(const Changes *c)
{
    for (uint32_t i = 0; i < c->head.channels; ++i) {
        if (c->channels[i].type > BOOLEAN) {
            return false;
        }
    }
    for (uint32_t k = 0; k < c->head.operations; ++k) {
        if (c->operations[k].channel >= c->head.channels || c->operations[k].kind > FREEZE) {
            return false;
        }
    }
    return true;
}

bool table_open(Changes *c, const char *resources, const char *guid, const char **reason)
{
    RecordFile file = {0, false};
    Head *h = &c->head;
    *reason = "resources/changes.bin cannot be read";
    bool whole = record_open(&file, resources, "changes.bin") && record_read(&file, h, sizeof *h);
    if (whole) {
        *reason = "resources/changes.bin is not that of this modelDescription.xml";
        whole = strcmp(h->magic, "CHANG1") == 0 && strcmp(h->guid, guid) == 0 && h->channels <= CHANNELS_MAX &&
                h->operations <= OPERATIONS_MAX && record_read(&file, c->channels, h->channels * sizeof(Channel)) &&
                record_read(&file, c->operations, h->operations * sizeof(Operation)) && sound(c);
    }
    record_close(&file);
    table_reset(c);
    return whole;
}

void table_reset(Changes *c)
{
    for (uint32_t i = 0; i < CHANNELS_MAX; ++i) {
        c->inputs[i] = c->before[i] = c->channels[i].input;
        c->delayed[i] = c->channels[i].start;
    }
    for (uint32_t k = 0; k < OPERATIONS_MAX; ++k) {
        c->acting[k] = (Acting){.acts = c->operations[k].at_start != 0, .frozen = false};
        c->frozen[k] = 0.0;
    }
}

void table_begin(Changes *c)
{
    memcpy(c->before, c->inputs, sizeof c->before);
}

/* What the operations before `end` make of a channel's value: all that act, in their order, the latest on top. */
static double changed(const Changes *c, uint32_t channel, uint32_t end)
{
    const Channel *row = &c->channels[channel];
    double value = row->delayed || !row->fed ? c->delayed[channel] : c->inputs[channel];
    for (uint32_t k = 0; k < end; ++k) {
        const Operation *o = &c->operations[k];
        if (o->channel == channel && c->acting[k].acts) {
            value = o->kind == REPLACE ? o->value : o->kind == ADD ? value + o->value : value;
            value = c->acting[k].frozen ? c->frozen[k] : value;
        }
    }
    return value;
}

void table_step(Changes *c, double t, double h)
{
    for (uint32_t i = 0; i < c->head.channels; ++i) {
        if (c->channels[i].delayed) {
            c->delayed[i] = c->before[i];
            c->before[i] = c->inputs[i];
        }
    }
    for (uint32_t k = 0; k < c->head.operations; ++k) {
        const Operation *o = &c->operations[k];
        const double instant = (o->before ? t : t + h) + SHORT * h;
        c->acting[k].acts = instant >= o->from && instant < o->until;
        if (c->acting[k].acts && o->kind == FREEZE && !c->acting[k].frozen) {
            c->frozen[k] = changed(c, o->channel, k);
            c->acting[k].frozen = true;
        }
    }
}

double table_output(const Changes *c, uint32_t channel)
{
    return changed(c, channel, c->head.operations);
}
