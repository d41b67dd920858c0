/* An FMU of another team for the generated set: one of our blocks behind ports of other conventions.
 *
 * The block is resources/block, and what is different stands in resources/table, whose words wrapper.py writes:
 *   inputs N, outputs N          reals of this FMU, references 0.. and 1000..
 *   real|integer|boolean R V     a parameter of the block
 *   in linear ...                inputs of the block from those of this FMU: A theirs + c
 *   in attitude ...              the matrix R_NB from four or three numbers
 *   in turned ...                a body rate from one along inertial axes, or from one relative to LVLH
 *   in earth ...                 a vector of inertial axes from one along axes that turn with the Earth
 *   out linear ...               outputs of this FMU from those of the block
 *   effect ...                   what an output does besides: late, stuck, saturated, noisy and so on
 * Linked with as_fmi3.c it is one of FMI 3.0. */
#include <dlfcn.h>
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define API __attribute__((visibility("default")))
enum { OK, WARNING, DISCARD, ERROR, FATAL };
enum { MOST = 64, PAST = 256, OUTPUTS = 1000 };
enum { LINEAR, ATTITUDE, TURNED, EARTH };
enum { DELAY, HOLD, STUCK, LIMIT, LAG, NOISE, DEAD, QUANTUM, SINGLE };

typedef struct {
    int kind, rows, columns;
    unsigned ours[16];
    int theirs[16];
    double A[144], c[16];
    int form, inverse, earth_velocity;
    double factor;
} Port;
typedef struct {
    int kind, at;
    double value, memory;
    int count;
} Effect;
typedef struct {
    void *library, *block;
    double in[MOST], out[MOST], past[PAST][MOST];
    int inputs, outputs, running, fresh, entries, readings, effects, parameters;
    long steps;
    double time, step;
    Port read[16], give[16];
    Effect effect[64];
    struct {
        int kind;
        unsigned reference;
        double value;
    } parameter[128];
    unsigned long long random;
    void *(*instantiate)(const char *, int, const char *, const char *, const void *, int, int);
    void (*release)(void *);
    int (*setup)(void *, int, double, double, int, double), (*enter)(void *), (*leave)(void *), (*terminate)(void *),
        (*reset)(void *);
    int (*get)(void *, const unsigned *, size_t, double *), (*set)(void *, const unsigned *, size_t, const double *),
        (*set_integer)(void *, const unsigned *, size_t, const int *),
        (*set_boolean)(void *, const unsigned *, size_t, const int *);
    int (*advance)(void *, double, double, int);
} Vendor;

/* ------------------------------------------------------------ the table */

static int port(FILE *file, Port *p, const char *kind)
{
    p->kind = !strcmp(kind, "linear")     ? LINEAR
              : !strcmp(kind, "attitude") ? ATTITUDE
              : !strcmp(kind, "turned")   ? TURNED
                                          : EARTH;
    int ok = fscanf(file, "%d %d %d %d %d %lf", &p->rows, &p->columns, &p->form, &p->inverse, &p->earth_velocity,
                    &p->factor) == 6;
    for (int i = 0; i < p->rows; i++)
        ok = ok && fscanf(file, "%u", &p->ours[i]) == 1;
    for (int i = 0; i < p->columns; i++)
        ok = ok && fscanf(file, "%d", &p->theirs[i]) == 1;
    const int n = p->kind == ATTITUDE ? 0 : p->rows * p->columns;
    for (int i = 0; i < n; i++)
        ok = ok && fscanf(file, "%lf", &p->A[i]) == 1;
    for (int i = 0; n && i < (p->rows > p->columns ? p->rows : p->columns); i++)
        ok = ok && fscanf(file, "%lf", &p->c[i]) == 1;
    return ok;
}

static int table(Vendor *v, const char *path)
{
    FILE *file = fopen(path, "r");
    char word[32], kind[32];
    int ok = file != NULL;
    while (ok && fscanf(file, "%31s", word) == 1) {
        if (!strcmp(word, "inputs")) {
            ok = fscanf(file, "%d", &v->inputs) == 1;
        } else if (!strcmp(word, "outputs")) {
            ok = fscanf(file, "%d", &v->outputs) == 1;
        } else if (!strcmp(word, "in")) {
            ok = fscanf(file, "%31s", kind) == 1 && port(file, &v->read[v->entries++], kind);
        } else if (!strcmp(word, "out")) {
            ok = fscanf(file, "%31s", kind) == 1 && port(file, &v->give[v->readings++], kind);
        } else if (!strcmp(word, "effect")) {
            Effect *e = &v->effect[v->effects++];
            ok = fscanf(file, "%d %d %lf", &e->kind, &e->at, &e->value) == 3;
        } else if (!strcmp(word, "start")) {
            int at;
            ok = fscanf(file, "%d", &at) == 1 && fscanf(file, "%lf", &v->in[at]) == 1;
        } else {
            const int n = v->parameters++;
            v->parameter[n].kind = !strcmp(word, "real") ? 0 : !strcmp(word, "integer") ? 1 : 2;
            ok = fscanf(file, "%u %lf", &v->parameter[n].reference, &v->parameter[n].value) == 2;
        }
    }
    if (file)
        fclose(file);
    return ok;
}

/* ------------------------------------------------------------ conversions */

static void product(const double A[9], const double B[9], double C[9])
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            C[3 * i + j] = A[3 * i] * B[j] + A[3 * i + 1] * B[3 + j] + A[3 * i + 2] * B[6 + j];
}

static void about(int axis, double angle, double R[9])
{
    const double c = cos(angle), s = sin(angle);
    const int i = (axis + 1) % 3, j = (axis + 2) % 3;
    memset(R, 0, 9 * sizeof *R);
    R[4 * axis] = 1.0;
    R[4 * i] = R[4 * j] = c;
    R[3 * i + j] = -s;
    R[3 * j + i] = s;
}

static void of_quaternion(double w, double x, double y, double z, double R[9])
{
    const double n = sqrt(w * w + x * x + y * y + z * z);
    w /= n, x /= n, y /= n, z /= n;
    const double M[9] = {1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),
                         2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
                         2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y)};
    memcpy(R, M, sizeof M);
}

/* form: 0 and 1 quaternion, scalar first and last; 2 MRP; 3 rotation vector; 100 a + 10 b + c Euler angles about turned axes */
static void attitude(const Port *p, const double *theirs, double R[9])
{
    double u[4], A[9], B[9], C[9], M[9];
    for (int i = 0; i < p->columns; i++)
        u[i] = theirs[p->theirs[i]] * p->factor;
    if (p->form == 0) {
        of_quaternion(u[0], u[1], u[2], u[3], M);
    } else if (p->form == 1) {
        of_quaternion(u[3], u[0], u[1], u[2], M);
    } else if (p->form == 2) {
        const double s = u[0] * u[0] + u[1] * u[1] + u[2] * u[2];
        of_quaternion(1 - s, 2 * u[0], 2 * u[1], 2 * u[2], M);
    } else if (p->form == 3) {
        const double angle = sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
        const double s = angle > 1e-12 ? sin(angle / 2) / angle : 0.5;
        of_quaternion(cos(angle / 2), s * u[0], s * u[1], s * u[2], M);
    } else {
        about(p->form / 100 - 4, u[0], A);
        about(p->form / 10 % 10, u[1], B);
        about(p->form % 10, u[2], C);
        product(A, B, R);
        product(R, C, M);
    }
    for (int i = 0; i < 9; i++)
        R[i] = p->inverse ? M[3 * (i % 3) + i / 3] : M[i];
}

static void convert(Vendor *v)
{
    double R[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, r[3] = {1, 0, 0}, w[3] = {0, 0, 0}, x[16], y[16];
    for (int pass = 0; pass < 2; pass++) { /* first what the others need: the attitude and the orbit */
        for (int k = 0; k < v->entries; k++) {
            const Port *p = &v->read[k];
            if ((p->kind == TURNED) != (pass == 1))
                continue;
            if (p->kind == ATTITUDE) {
                attitude(p, v->in, x);
            } else {
                for (int i = 0; i < p->rows; i++) {
                    x[i] = p->c[i];
                    for (int j = 0; j < p->columns; j++)
                        x[i] += p->A[p->columns * i + j] * v->in[p->theirs[j]];
                }
            }
            if (p->kind == EARTH) {
                double turn[9];
                const double rate = 7.2921159e-5;
                about(2, p->factor + rate * v->time, turn);
                memcpy(y, x, sizeof y);
                for (int i = 0; i < 3; i++)
                    x[i] = turn[3 * i] * y[0] + turn[3 * i + 1] * y[1] + turn[3 * i + 2] * y[2];
            }
            if (p->kind == TURNED) {
                memcpy(y, x, sizeof y);
                for (int i = 0; i < 3; i++) /* form 0: along inertial axes; 1: relative to LVLH */
                    x[i] = p->form ? y[i] + R[i] * w[0] + R[3 + i] * w[1] + R[6 + i] * w[2]
                                   : R[i] * y[0] + R[3 + i] * y[1] + R[6 + i] * y[2];
            }
            if (p->rows == 9)
                memcpy(R, x, sizeof R);
            if (p->earth_velocity == 1)
                memcpy(r, x, sizeof r);
            if (p->earth_velocity == 2) {
                const double s = r[0] * r[0] + r[1] * r[1] + r[2] * r[2];
                w[0] = (r[1] * x[2] - r[2] * x[1]) / s;
                w[1] = (r[2] * x[0] - r[0] * x[2]) / s;
                w[2] = (r[0] * x[1] - r[1] * x[0]) / s;
            }
            v->set(v->block, p->ours, (size_t)p->rows, x);
        }
    }
}

static double normal(Vendor *v)
{
    double sum = 0.0;
    for (int i = 0; i < 12; i++) {
        v->random = v->random * 6364136223846793005ull + 1442695040888963407ull;
        sum += (double)(v->random >> 11) / 9007199254740992.0;
    }
    return sum - 6.0;
}

static int outputs(Vendor *v, int stepped)
{
    int status = OK;
    double x[16], made[MOST];
    for (int k = 0; k < v->readings; k++) {
        const Port *p = &v->give[k];
        const int now = v->get(v->block, p->ours, (size_t)p->rows, x);
        status = now > status ? now : status;
        for (int i = 0; i < p->columns; i++) {
            double sum = p->c[i];
            for (int j = 0; j < p->rows; j++)
                sum += p->A[p->rows * i + j] * x[j];
            made[p->theirs[i]] = sum;
        }
    }
    if (stepped || v->steps == 0)
        memcpy(v->past[v->steps % PAST], made, sizeof made);
    for (int k = 0; k < v->effects; k++) {
        Effect *e = &v->effect[k];
        double *y = &made[e->at];
        const int late = (int)floor(e->value);
        const long a = v->steps - late > 0 ? v->steps - late : 0, b = v->steps - late - 1 > 0 ? v->steps - late - 1 : 0;
        const double part = e->value - late, value = e->value;
        switch (e->kind) {
        case DELAY:
            *y = (1 - part) * v->past[a % PAST][e->at] + part * v->past[b % PAST][e->at];
            break;
        case HOLD:
            *y = v->past[(v->steps - v->steps % (long)value) % PAST][e->at];
            break;
        case STUCK:
            if (stepped && v->time < value - 1e-9)
                e->memory = *y;
            *y = v->time < value - 1e-9 ? *y : e->memory;
            break;
        case LIMIT:
            *y = fmax(-value, fmin(value, *y));
            break;
        case LAG:
            if (stepped)
                e->memory += (1 - exp(-v->step / value)) * (*y - e->memory);
            else if (v->steps == 0)
                e->memory = *y;
            *y = e->memory;
            break;
        case NOISE:
            if (stepped)
                e->memory = value * normal(v);
            *y += e->memory;
            break;
        case DEAD:
            *y = fabs(*y) < value ? 0.0 : *y;
            break;
        case QUANTUM:
            *y = value * round(*y / value);
            break;
        default:
            *y = (float)*y;
        }
    }
    memcpy(v->out, made, sizeof made);
    return status;
}

/* ------------------------------------------------------------ FMI 2.0 */

static int begin(Vendor *v)
{
    int status = OK;
    v->random = 88172645463325252ull;
    v->steps = 0, v->time = 0.0, v->running = 0;
    for (int i = 0; i < v->effects; i++)
        v->effect[i].memory = 0.0;
    for (int i = 0; i < v->parameters && status <= WARNING; i++) {
        const int number = (int)v->parameter[i].value;
        const unsigned *r = &v->parameter[i].reference;
        status = v->parameter[i].kind == 0   ? v->set(v->block, r, 1, &v->parameter[i].value)
                 : v->parameter[i].kind == 1 ? v->set_integer(v->block, r, 1, &number)
                                             : v->set_boolean(v->block, r, 1, &number);
    }
    return status;
}

API const char *fmi2GetVersion(void)
{
    return "2.0";
}
API const char *fmi2GetTypesPlatform(void)
{
    return "default";
}
API void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources, const void *callbacks,
                          int visible, int logging)
{
    char path[4096], folder[4000];
    if (!strncmp(resources, "file://", 7))
        resources += 7;
    while (resources[0] == '/' && resources[1] == '/')
        resources++;
    snprintf(folder, sizeof folder, "%s%s", resources, resources[strlen(resources) - 1] == '/' ? "" : "/");
    Vendor *v = calloc(1, sizeof *v);
    snprintf(path, sizeof path, "%stable", folder);
    if (!v || !table(v, path))
        return NULL;
    snprintf(path, sizeof path, "%sinner", folder);
    v->library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!v->library)
        return NULL;
#define FIND(field, name) *(void **)&v->field = dlsym(v->library, #name)
    FIND(instantiate, fmi2Instantiate), FIND(release, fmi2FreeInstance), FIND(setup, fmi2SetupExperiment);
    FIND(enter, fmi2EnterInitializationMode), FIND(leave, fmi2ExitInitializationMode), FIND(terminate, fmi2Terminate);
    FIND(reset, fmi2Reset), FIND(get, fmi2GetReal), FIND(set, fmi2SetReal), FIND(set_integer, fmi2SetInteger);
    FIND(set_boolean, fmi2SetBoolean), FIND(advance, fmi2DoStep);
    snprintf(path, sizeof path, "%sguid", folder);
    char inner[128] = "";
    FILE *file = fopen(path, "r");
    if (file) {
        if (!fgets(inner, sizeof inner, file))
            inner[0] = 0;
        fclose(file);
    }
    (void)guid;
    v->block = v->instantiate(name, type, inner, "", callbacks, visible, logging);
    if (!v->block || begin(v) > WARNING) {
        free(v);
        return NULL;
    }
    return v;
}
API void fmi2FreeInstance(void *instance)
{
    Vendor *v = instance;
    if (v) {
        v->release(v->block);
        free(v);
    }
}
API int fmi2SetupExperiment(void *instance, int defined, double tolerance, double start, int stops, double stop)
{
    Vendor *v = instance;
    return v->setup(v->block, defined, tolerance, start, stops, stop);
}
API int fmi2EnterInitializationMode(void *instance)
{
    return ((Vendor *)instance)->enter(((Vendor *)instance)->block);
}
API int fmi2ExitInitializationMode(void *instance)
{
    Vendor *v = instance;
    convert(v);
    int status = v->leave(v->block);
    const int given = outputs(v, 0);
    v->running = 1;
    return status > given ? status : given;
}
API int fmi2Terminate(void *instance)
{
    return ((Vendor *)instance)->terminate(((Vendor *)instance)->block);
}
API int fmi2Reset(void *instance)
{
    Vendor *v = instance;
    const int status = v->reset(v->block);
    return status > WARNING ? status : begin(v);
}
API int fmi2SetReal(void *instance, const unsigned *references, size_t count, const double *values)
{
    Vendor *v = instance;
    for (size_t i = 0; i < count; i++) {
        if (references[i] >= (unsigned)v->inputs)
            return ERROR;
        v->in[references[i]] = values[i];
    }
    return OK;
}
API int fmi2GetReal(void *instance, const unsigned *references, size_t count, double *values)
{
    Vendor *v = instance;
    if (!v->running) {
        convert(v);
        const int status = outputs(v, 0);
        if (status > WARNING)
            return status;
    }
    for (size_t i = 0; i < count; i++)
        values[i] = references[i] < OUTPUTS ? v->in[references[i]] : v->out[references[i] - OUTPUTS];
    return OK;
}
API int fmi2DoStep(void *instance, double time, double step, int keep)
{
    Vendor *v = instance;
    v->time = time + step, v->step = step;
    convert(v);
    const int status = v->advance(v->block, time, step, keep);
    v->steps++;
    const int given = status > WARNING ? status : outputs(v, 1);
    return status > given ? status : given;
}

#define NONE(name)                                                                                                     \
    API int fmi2##name(void);                                                                                          \
    API int fmi2##name(void)                                                                                           \
    {                                                                                                                  \
        return ERROR;                                                                                                  \
    }
NONE(SetDebugLogging)
NONE(GetInteger)
NONE(GetBoolean)
NONE(GetString)
NONE(SetInteger)
NONE(SetBoolean)
NONE(SetString)
NONE(GetFMUstate)
NONE(SetFMUstate)
NONE(FreeFMUstate)
NONE(SerializedFMUstateSize)
NONE(SerializeFMUstate)
NONE(DeSerializeFMUstate)
NONE(GetDirectionalDerivative)
NONE(SetRealInputDerivatives)
NONE(GetRealOutputDerivatives)
NONE(CancelStep)
NONE(GetStatus)
NONE(GetRealStatus)
NONE(GetIntegerStatus)
NONE(GetBooleanStatus)
NONE(GetStringStatus)
