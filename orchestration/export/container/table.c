/* The tables of resources/container.bin, and what loop.c needs of them. */
#include <string.h>

#include "container.h"
#include "record_file.h"

enum { AS_DOUBLE = 0, AS_INT32 = 6 }; /* among the types of loop.c */

void *container_take(Container *c, size_t count, size_t size)
{
    enum { BEFORE = 16 }; /* keeps what follows aligned */
    const size_t bytes = count * size + BEFORE;
    char *piece = c->host.calls.allocateMemory(1, bytes);
    if (piece == NULL) {
        return NULL;
    }
    memset(piece, 0, bytes);
    memcpy(piece, &c->taken, sizeof c->taken);
    c->taken = piece;
    return piece + BEFORE;
}

/* Whether the rows lead nowhere beyond the tables. */
static bool sound(const Container *c)
{
    const Head *h = &c->head;
    bool good = c->text[h->text - 1] == '\0';
    for (uint32_t i = 0; i < h->blocks; ++i) {
        const BlockRow *r = &c->blocks[i];
        good = good && r->name < h->text && r->guid < h->text && r->folder < h->text && r->identifier < h->text;
    }
    for (uint32_t i = 0; i < h->variables; ++i) {
        const VariableRow *r = &c->variables[i];
        good = good && r->kind < KINDS &&
               (r->block < h->blocks || (r->block == NO_BLOCK && r->kind == KIND_REAL && r->settable == 0));
    }
    for (uint32_t i = 0; i < h->starts; ++i) {
        good = good && c->starts[i].kind < KINDS && c->starts[i].block < h->blocks && c->starts[i].text < h->text;
    }
    for (uint32_t i = 0; i < h->inputs; ++i) {
        const InputRow *r = &c->inputs[i];
        good = good && r->end.kind < KIND_STRING && r->end.block < h->blocks && r->end.place < h->outputs;
    }
    for (uint32_t i = 0; i < h->outputs; ++i) {
        const End *r = &c->outputs[i];
        good = good && r->kind < KIND_STRING && r->block < h->blocks && r->place < h->text;
    }
    for (uint32_t i = 0; i < h->initial; ++i) {
        good = good && c->initial[i] < h->inputs;
    }
    return good;
}

bool table_open(Container *c, const char *resources, const char *guid, const char **reason)
{
    enum { MOST = 1 << 20 };
    RecordFile file = {0, false};
    Head *h = &c->head;
    *reason = "resources/container.bin cannot be read";
    bool whole = record_open(&file, resources, "container.bin") && record_read(&file, h, sizeof *h);
    if (whole) {
        *reason = "resources/container.bin is not that of this modelDescription.xml";
        whole = memcmp(h->magic, "CNTNR1\0", 8) == 0 && h->guid[sizeof h->guid - 1] == '\0' &&
                strcmp(h->guid, guid) == 0 && h->blocks <= MOST && h->variables <= MOST && h->starts <= MOST &&
                h->inputs <= MOST && h->outputs <= MOST && h->initial <= MOST && h->text > 0 && h->text <= 64u * MOST &&
                h->numerator > 0.0 && h->denominator > 0.0;
    }
    const struct {
        void *into;
        size_t count, size;
    } tables[] = {{&c->blocks, h->blocks, sizeof *c->blocks},    {&c->variables, h->variables, sizeof *c->variables},
                  {&c->starts, h->starts, sizeof *c->starts},    {&c->inputs, h->inputs, sizeof *c->inputs},
                  {&c->outputs, h->outputs, sizeof *c->outputs}, {&c->initial, h->initial, sizeof *c->initial},
                  {&c->text, h->text, sizeof *c->text}};
    *reason = whole ? "resources/container.bin is damaged: expected the tables that its head announces" : *reason;
    for (size_t i = 0; whole && i < sizeof tables / sizeof tables[0]; ++i) {
        void *const rows = container_take(c, tables[i].count, tables[i].size);
        memcpy(tables[i].into, &rows, sizeof rows);
        whole = rows != NULL && record_read(&file, rows, tables[i].count * tables[i].size);
    }
    record_close(&file);
    return whole && sound(c);
}

/* A Get or Set of `count` numbers of one kind, which lie side by side at `values`. */
static bool lay(Container *c, Exchange *it, uint32_t kind, Access function, double *values, size_t count)
{
    it->values = values;
    it->type = kind == KIND_REAL ? AS_DOUBLE : AS_INT32;
    memcpy(&it->function, &function, sizeof function);
    it->low = kind == KIND_REAL ? -1.0 / 0.0 : -2147483648.0;
    it->beyond = kind == KIND_REAL ? 1.0 / 0.0 : 2147483648.0;
    it->live = it->all = (Part){count, count, count};
    it->buffer = values;
    if (kind != KIND_REAL) {
        int64_t *const places = container_take(c, count, sizeof *places);
        it->buffer = container_take(c, count, sizeof(fmi2Integer));
        it->places = it->slots = places;
        for (size_t i = 0; places != NULL && i < count; ++i) {
            places[i] = (int64_t)i;
        }
    }
    return function != NULL && it->buffer != NULL && (kind == KIND_REAL || it->places != NULL);
}

/* The inputs or outputs of a block, whose rows stand `stride` bytes apart: one Exchange for each kind. */
static bool lay_side(Container *c, const void *rows, size_t stride, size_t count, const Access functions[],
                     double *values, const Exchange **exchanges, size_t *number)
{
    Exchange *const made = container_take(c, KINDS, sizeof *made);
    uint32_t *const references = container_take(c, count, sizeof *references);
    bool good = made != NULL && references != NULL;
    size_t end = 0;
    for (uint32_t kind = KIND_REAL; good && kind < KIND_STRING; ++kind) {
        const size_t begin = end;
        for (; end < count; ++end) {
            const End *const row = (const void *)((const char *)rows + end * stride);
            if (row->kind != kind) {
                break;
            }
            references[end] = row->reference;
        }
        if (end > begin) {
            made[*number].references = references + begin;
            good = lay(c, &made[(*number)++], kind, functions[kind], values + begin, end - begin);
        }
    }
    *exchanges = made;
    return good && end == count;
}

bool table_lay_out(Container *c)
{
    const Head *h = &c->head;
    Seat *const seats = container_take(c, h->blocks, sizeof *seats);
    int64_t *const sources = container_take(c, h->inputs, sizeof *sources);
    double *const factors = container_take(c, h->inputs, sizeof *factors);
    double *const offsets = container_take(c, h->inputs, sizeof *offsets);
    c->bus = container_take(c, h->outputs, sizeof *c->bus);
    c->values = container_take(c, h->inputs, sizeof *c->values);
    bool good =
        seats != NULL && sources != NULL && factors != NULL && offsets != NULL && c->bus != NULL && c->values != NULL;
    for (uint32_t i = 0; good && i < h->inputs; ++i) {
        sources[i] = c->inputs[i].end.place;
        factors[i] = c->inputs[i].factor;
        offsets[i] = c->inputs[i].offset;
    }
    uint32_t in = 0, out = 0;
    for (uint32_t k = 0; good && k < h->blocks; ++k) {
        Inner *const inner = &c->inner[k];
        const uint32_t first_in = in, first_out = out;
        bool converted = false;
        for (; in < h->inputs && c->inputs[in].end.block == k; ++in) {
            converted = converted || factors[in] != 1.0 || offsets[in] != 0.0;
        }
        while (out < h->outputs && c->outputs[out].block == k) {
            ++out;
        }
        Seat *const seat = &seats[k];
        *seat = (Seat){.component = inner->instance,
                       .do_step = {inner->step},
                       .version = 2,
                       .every = 1,
                       .step = h->numerator / h->denominator,
                       .sources = sources + first_in,
                       .factors = converted ? factors + first_in : NULL,
                       .offsets = offsets + first_in,
                       .inputs = c->values + first_in,
                       .input_count = in - first_in,
                       .outputs = c->bus + first_out,
                       .output_count = out - first_out};
        good = lay_side(c, c->inputs + first_in, sizeof *c->inputs, seat->input_count, inner->set, seat->inputs,
                        &seat->setters, &seat->setter_count) &&
               lay_side(c, c->outputs + first_out, sizeof *c->outputs, seat->output_count, inner->get,
                        c->bus + first_out, &seat->getters, &seat->getter_count);
    }
    c->loop = (Loop){.seats = seats,
                     .seat_count = h->blocks,
                     .parallel = h->parallel != 0,
                     .bus = c->bus,
                     .rows = c->bus,          /* no row is recorded: */
                     .interval = INT64_MAX,   /* there is no such step */
                     .observed_rows = c->bus, /* of which none is taken */
                     .numerator = h->numerator,
                     .denominator = h->denominator};
    return good && in == h->inputs && out == h->outputs;
}
