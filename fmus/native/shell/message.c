/* Messages, without stdio: so the shell needs no C library. Tests: tests/native/test_refusals.py. */
#include "instance.h"

#include <float.h>
#include <math.h>

Message message(const char *text)
{
    Message m;
    m.text[0] = '\0';
    m.length = 0;
    put(&m, text);
    return m;
}

Message about(const Instance *c, const char *function)
{
    return message(c->called != NULL ? c->called : function);
}

void put(Message *m, const char *text)
{
    for (; *text != '\0' && m->length + 1 < sizeof m->text; ++text) {
        m->text[m->length++] = *text;
    }
    m->text[m->length] = '\0';
}

static void put_digits(Message *m, uint64_t digits, int least)
{
    char reversed[24];
    int n = 0;
    do {
        reversed[n++] = (char)('0' + (int)(digits % 10));
        digits /= 10;
    } while (digits != 0 || n < least); /* 64 bits have 20 digits at most, and least is 12 at most */
    while (n > 0) {
        const char one[2] = {reversed[--n], '\0'};
        put(m, one);
    }
}

/* Ten to the n, for a message. */
static double power_of_ten(int n)
{
    double x = 1.0;
    for (; n > 0; --n) {
        x *= 10.0;
    }
    for (; n < 0; ++n) {
        x /= 10.0;
    }
    return x;
}

/* x >= 0 as d.ddd 10^exponent: its significant digits as an integer, nine at most without trailing zeros, and their
 * count. */
static uint64_t digits_of(double x, int *exponent, int *count)
{
    *exponent = 0;
    for (double y = x; y >= 10.0; y /= 10.0) {
        ++*exponent;
    }
    for (double y = x; y < 1.0 && y > 0.0; y *= 10.0) {
        --*exponent;
    }
    /* Two factors, since ten to the 8 - exponent may overflow. */
    const int half = (8 - *exponent) / 2;
    uint64_t digits = (uint64_t)(x * power_of_ten(half) * power_of_ten(8 - *exponent - half) + 0.5);
    if (digits >= 1000000000u) {
        digits /= 10;
        ++*exponent;
    }
    for (*count = 9; *count > 1 && digits % 10 == 0; --*count) {
        digits /= 10;
    }
    return digits;
}

/* Nine significant digits, as printf's %.9g. */
void put_number(Message *m, double x)
{
    if (isnan(x)) {
        put(m, "NaN");
        return;
    }
    if (x < 0.0) {
        put(m, "-");
        x = -x;
    }
    if (isinf(x)) {
        put(m, "infinity");
        return;
    }
    int exponent, count;
    const uint64_t digits = digits_of(x, &exponent, &count);
    const bool scientific = exponent < -4 || exponent > 8;
    const int before = scientific ? 1 : exponent + 1; /* digits before the point */
    if (before >= count) {
        put_digits(m, digits * (uint64_t)(power_of_ten(before - count) + 0.5), 1);
    } else if (before > 0) {
        const uint64_t unit = (uint64_t)(power_of_ten(count - before) + 0.5);
        put_digits(m, digits / unit, 1);
        put(m, ".");
        put_digits(m, digits % unit, count - before);
    } else {
        put(m, "0.");
        put_digits(m, digits, count - before);
    }
    if (scientific) {
        put(m, exponent < 0 ? "e-" : "e+");
        put_digits(m, (uint64_t)(exponent < 0 ? -exponent : exponent), 2);
    }
}

/* FMI 2.0's logger takes a printf format: a % of a caller's text is doubled, as is its # before a value reference. With
 * FMI 3.0 the functions in the text have the names of that version. */
static void send(const Instance *c, fmi2Status status, const char *category, const char *text)
{
    Message m = message("");
    if (c->callbacks.logger == NULL) {
        return;
    }
    for (; *text != '\0'; ++text) {
        const bool doubled = BLOCK_FMI == 2 && (*text == '%' || *text == '#');
        const char one[3] = {*text, doubled ? *text : '\0', '\0'};
        if (m.length + 3 < sizeof m.text) {
            put(&m, one);
        }
        if (BLOCK_FMI == 3 && m.length >= 4 && memcmp(&m.text[m.length - 4], "fmi2", 4) == 0) {
            m.text[m.length - 1] = '3';
        }
    }
    c->callbacks.logger(c->callbacks.componentEnvironment, c->name, status, category, m.text);
}

fmi2Status refuse(const Instance *c, const Message *m)
{
    send(c, fmi2Error, "logStatusError", m->text);
    return fmi2Error;
}

fmi2Status refuse_text(const Instance *c, const char *function, const char *text)
{
    Message m = about(c, function);
    put(&m, ": ");
    put(&m, text);
    return refuse(c, &m);
}

fmi2Status refuse_fault(const Instance *c, const char *function, const Fault *f)
{
    Message m = about(c, function);
    put(&m, ": ");
    put(&m, f->name);
    put(&m, ": expected ");
    put(&m, f->expected);
    put(&m, ", found ");
    if (f->text != NULL) {
        put(&m, "'");
        put(&m, f->text);
        put(&m, "'");
    } else {
        put_number(&m, f->value);
    }
    return refuse(c, &m);
}

static const char *const kinds[] = {"real", "integer", "boolean", "string"};

fmi2Status refuse_variable(const Instance *c, const char *function, const Variable *v, const char *text)
{
    Message m = about(c, function);
    put(&m, ": ");
    put(&m, v->name);
    put(&m, " ");
    put(&m, text);
    return refuse(c, &m);
}

bool refuse_reference(const Instance *c, const char *function, fmi2ValueReference reference, Kind kind)
{
    if (reference >= BLOCK_VARIABLES) {
        refuse_fault(c, function, &(Fault){"value reference", "that of a variable of this FMU", NULL, reference});
        return false;
    }
    Message m = message("is of type ");
    put(&m, kinds[variables[reference].kind]);
    put(&m, ", not ");
    put(&m, kinds[kind]);
    refuse_variable(c, function, &variables[reference], m.text);
    return false;
}

fmi2Status refuse_value(const Instance *c, const char *function, const Variable *v, double value)
{
    Message m = about(c, function);
    put(&m, ": ");
    put(&m, v->name);
    put(&m, ": expected ");
    if (v->min > -DBL_MAX && v->max < DBL_MAX) {
        put_number(&m, v->min);
        put(&m, " to ");
        put_number(&m, v->max);
    } else if (v->min > -DBL_MAX) {
        put(&m, "a finite number, at least ");
        put_number(&m, v->min);
    } else if (v->max < DBL_MAX) {
        put(&m, "a finite number, at most ");
        put_number(&m, v->max);
    } else {
        put(&m, "a finite number");
    }
    put(&m, ", found ");
    put_number(&m, value);
    return refuse(c, &m);
}

void log_event(const Instance *c, const char *text)
{
    if (c->log_events) {
        send(c, fmi2OK, "logAll", text);
    }
}
