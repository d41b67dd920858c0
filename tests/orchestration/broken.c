/* An FMU that breaks as its GUID says, "place-how": "step-abort" aborts in the first step that begins at 1 s or later.
 *
 * Real 0 is x, an input; real 1 is y, an output: the time. Three ways of breaking are compiled in: LOADING, MISSING and
 * WITHOUT_STEP. */
#include <fenv.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#define TELLS_ITS_END

#include "small_fmu.h"

typedef struct {
    double x, y;
    int stepping;
    char place[16], how[16];
    const Callbacks *callbacks;
} Block;
static const double FROM = 1.0;

#ifdef MISSING
extern int vendor_runtime_start(void);
#endif

static int say(Block *b, int status, const char *text, double value)
{
    return log_value(b->callbacks, "block", status, text, value);
}
static void crash(void)
{
    *(volatile int *)8 = 1;
}
static int overflow(volatile char *caller)
{
    volatile char frame[1 << 16];
    frame[0] = caller[0];
    return overflow(frame) + frame[0];
}
static void leave_a_child(void)
{
#if !defined(_WIN32)
    if (fork() == 0)
        for (;;)
            pause();
#endif
}

static int is(const Block *b, const char *how)
{
    return !strcmp(b->how, how);
}
static int broken(Block *b, double t)
{
    /* what others in the same process have, too */
    if (is(b, "round"))
        fesetround(FE_UPWARD);
    if (is(b, "deafen"))
        signal(SIGINT, SIG_IGN);
#if !defined(_WIN32)
    if (is(b, "signal"))
        signal(SIGCHLD, SIG_IGN);
#endif
    if (is(b, "flush")) /* numbers below the smallest normal one to zero */
#if defined(__SSE2__)
        __builtin_ia32_ldmxcsr(__builtin_ia32_stmxcsr() | 0x8040);
#elif defined(__aarch64__)
        __asm__ volatile("msr fpcr, %0" ::"r"(1ul << 24));
#endif
    if (is(b, "vanish"))
        _exit(0);
#if !defined(_WIN32)
    if (is(b, "kill"))
        kill(getpid(), SIGKILL);
    if (is(b, "real"))
        kill(getpid(), 40);
#endif
#if !defined(_WIN32)
    if (is(b, "limit"))
        setrlimit(RLIMIT_NOFILE, &(struct rlimit){3, 4096});
#endif
    if (is(b, "rid"))
        for (int i = 3; i < 64; i++)
            close(i);
    if (is(b, "silence"))
        for (int i = 0; i < 3; i++)
            close(i);
#if !defined(_WIN32)
    if (is(b, "move") && chdir("/"))
        return ERROR;
#endif
    if (is(b, "segfault"))
        crash();
    if (is(b, "abort"))
        abort();
    if (is(b, "exit"))
        exit(0);
    if (is(b, "overflow"))
        return overflow(b->how);
    if (is(b, "child")) {
        leave_a_child();
        crash();
    }
    if (is(b, "assert")) {
        fprintf(stderr, "driver.c:17: assertion failed: ready\n");
        abort();
    }
    if (is(b, "print")) {
        printf("no end of line after this");
        return ERROR;
    }
    if (is(b, "deaf") || is(b, "mute"))
        for (int i = 0; i < 64; i++)
            close(i);
#if !defined(_WIN32)
    while (is(b, "hang")) /* as one that waits for a device; the other one is busy */
        pause();
#endif
    if (is(b, "hang") || is(b, "deaf"))
        for (volatile int i = 0;; i = 1) {
        }
    while (is(b, "memory"))
        memset(malloc(1 << 20), 1, 1 << 20);
    while (is(b, "log"))
        say(b, OK, "and on from", t);
    while (is(b, "chatter"))
        puts("and on");
    if (is(b, "litter")) {
        FILE *f = fopen("litter.txt", "w");
        if (f)
            fclose(f);
        return say(b, ERROR, f ? "left a file at" : "left none at", t);
    }
    if (is(b, "nan"))
        b->y = NAN;
    if (is(b, "infinity"))
        b->y = INFINITY;
    if (is(b, "error"))
        return say(b, ERROR, "cannot go on from", t);
    if (is(b, "discard"))
        return say(b, DISCARD, "step too long at", t);
    if (is(b, "finish")) { /* fmi2GetBooleanStatus says that the simulation ends */
        b->x = NAN;
        return say(b, DISCARD, "that is all at", t);
    }
#if !defined(_WIN32)
    if (is(b,
           "shrink")) { /* each file that it may reach, and the one that is shared with the master where it has a name */
        int shrunk = truncate("../vendor.memory", 0) == 0;
        for (int i = 3; i < 64; i++)
            shrunk += ftruncate(i, 0) == 0;
        return say(b, ERROR, shrunk ? "has shortened files at" : "could shorten no file at", t);
    }
#endif
    if (is(b, "fatal"))
        return say(b, FATAL, "broken at", t);
    if (is(b, "pending"))
        return PENDING;
    /* as_fmi3.c makes answers of these */
    if (is(b, "event"))
        return 10 + 1;
    if (is(b, "end"))
        return 10 + 2;
    if (is(b, "early"))
        return 10 + 4;
    return OK;
}
#define BREAK(where, t)                                                                                                \
    if (!strcmp(b->place, where)) {                                                                                    \
        int status = broken(b, t);                                                                                     \
        if (status)                                                                                                    \
            return status;                                                                                             \
    }

#ifdef LOADING
__attribute__((constructor)) static void loaded(void)
{
    crash();
}
#endif

API void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources,
                          const Callbacks *callbacks, int visible, int logging)
{
    (void)name, (void)type, (void)resources, (void)visible, (void)logging;
    Block *b = calloc(1, sizeof *b);
    b->callbacks = callbacks;
    if (sscanf(guid, "%15[a-z]-%15[a-z]", b->place, b->how) != 2) {
        say(b, ERROR, "the GUID says nothing to", 0);
        return NULL;
    }
    if (!strcmp(b->place, "instantiate") && broken(b, 0))
        return NULL;
#ifdef MISSING
    vendor_runtime_start();
#endif
    return b;
}
API int fmi2SetupExperiment(void *c, int a, double tolerance, double start, int d, double stop)
{
    (void)a, (void)tolerance, (void)start, (void)d, (void)stop;
    Block *b = c;
    BREAK("setup", 0)
    return OK;
}
API int fmi2EnterInitializationMode(void *c)
{
    Block *b = c;
    BREAK("enter", 0) return OK;
}
API int fmi2ExitInitializationMode(void *c)
{
    Block *b = c;
    BREAK("leave", 0) return OK;
}
API int fmi2Terminate(void *c)
{
    Block *b = c;
    BREAK("terminate", 0) return OK;
}
API void fmi2FreeInstance(void *c)
{
    Block *b = c;
    if (!strcmp(b->place, "free"))
        broken(b, 0);
    free(b);
}

API int fmi2SetReal(void *c, const unsigned v[], size_t n, const double x[])
{
    Block *b = c;
    if (!b->stepping) {
        BREAK("set", 0)
    }
    if (b->stepping && b->y >= FROM) {
        BREAK("input", b->y)
    }
    for (size_t i = 0; i < n; i++)
        if (v[i] == 0)
            b->x = x[i];
    return OK;
}
API int fmi2GetReal(void *c, const unsigned v[], size_t n, double x[])
{
    Block *b = c;
    if (!b->stepping) {
        BREAK("get", 0)
    }
    if (b->stepping && b->y > FROM) {
        BREAK("output", b->y)
    }
    for (size_t i = 0; i < n; i++)
        x[i] = v[i] ? b->y : b->x;
    return OK;
}
API int fmi2GetInteger(void *c, const unsigned v[], size_t n, int x[])
{
    (void)c, (void)v, (void)n, (void)x;
    return OK;
}
API int fmi2SetInteger(void *c, const unsigned v[], size_t n, const int x[])
{
    (void)c, (void)v, (void)n, (void)x;
    return OK;
}
API int fmi2GetBoolean(void *c, const unsigned v[], size_t n, int x[])
{
    (void)c, (void)v, (void)n, (void)x;
    return OK;
}
API int fmi2SetBoolean(void *c, const unsigned v[], size_t n, const int x[])
{
    (void)c, (void)v, (void)n, (void)x;
    return OK;
}
API int fmi2GetBooleanStatus(void *c, int kind, int *value)
{
    const Block *b = c;
    *value = kind == 3 && isnan(b->x); /* fmi2Terminated */
    return OK;
}
#ifndef WITHOUT_STEP
API int fmi2DoStep(void *c, double t, double h, int keep)
{
    (void)keep;
    Block *b = c;
    b->stepping = 1;
    b->y = t + h;
    if (t >= FROM) {
        say(b, OK, "stepping from", t);
        BREAK("step", t)
    }
    return OK;
}
#endif
