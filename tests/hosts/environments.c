/* A host whose floating-point environment is not the default one, in a thread with a small stack, on Linux: runs the
 * cases that it reads from its input in the first few environments of environments.h, in both kinds and versions of
 * FMI. It fails where a call or a callback finds another environment than this host has, or where anything differs by a
 * bit from what is computed in the default environment. Prints the names of the cases in which calls are refused.
 *
 * The first lines of the input are a letter and value references: of real variables (r), counts (i) and booleans (b) to
 * read, of unknowns (u) and knowns (k), and of parameters (p), for derivatives; and n, the numbers of continuous states
 * and event indicators. Each line after them is a case: its name and start values, r:REFERENCE=VALUE or e:... */

#include <dlfcn.h>
#include <pthread.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "environments.h"
#include "fmi2FunctionTypes.h"
#include "fmi3FunctionTypes.h"

/* The functions of the FMU, by their names. */
#define BOTH(DO, v) \
    DO(v##EnterInitializationMode) DO(v##ExitInitializationMode) DO(v##Terminate) DO(v##Reset) DO(v##FreeInstance) \
    DO(v##GetBoolean) DO(v##GetDirectionalDerivative) DO(v##DoStep) DO(v##EnterEventMode) \
    DO(v##EnterContinuousTimeMode) DO(v##CompletedIntegratorStep) DO(v##SetTime) DO(v##SetContinuousStates) \
    DO(v##GetContinuousStates) DO(v##GetEventIndicators) DO(v##GetNominalsOfContinuousStates)
#define FUNCTIONS(DO) \
    BOTH(DO, fmi2) BOTH(DO, fmi3) DO(fmi2Instantiate) DO(fmi2SetupExperiment) DO(fmi2GetReal) DO(fmi2GetInteger) \
    DO(fmi2SetReal) DO(fmi2SetInteger) DO(fmi2GetFMUstate) DO(fmi2SetFMUstate) DO(fmi2FreeFMUstate) \
    DO(fmi2SerializedFMUstateSize) DO(fmi2SerializeFMUstate) DO(fmi2DeSerializeFMUstate) DO(fmi2GetDerivatives) \
    DO(fmi2SetRealInputDerivatives) DO(fmi2GetRealOutputDerivatives) DO(fmi2NewDiscreteStates) \
    DO(fmi3InstantiateCoSimulation) DO(fmi3InstantiateModelExchange) DO(fmi3GetFloat64) DO(fmi3GetUInt64) \
    DO(fmi3SetFloat64) DO(fmi3SetInt64) DO(fmi3GetFMUState) DO(fmi3SetFMUState) DO(fmi3FreeFMUState) \
    DO(fmi3SerializedFMUStateSize) DO(fmi3SerializeFMUState) DO(fmi3DeserializeFMUState) \
    DO(fmi3GetContinuousStateDerivatives) DO(fmi3GetOutputDerivatives) DO(fmi3UpdateDiscreteStates) \
    DO(fmi3EnterStepMode) DO(fmi3GetAdjointDerivative)
#define DECLARE(name) static name##TYPE *name;
#define LOAD(name) if (!(name = (name##TYPE *)dlsym(library, #name))) fail("is missing: " #name);
FUNCTIONS(DECLARE)

enum { MOST = 1024, STEPS = 6, SOLVER_STEPS = 100, CASES = 1000 };
static const double STEP = 1.0 / 512, SOLVER_STEP = 1.0 / 16384; /* s */

static char *resource_uri, *resource_path, *guid, *token;
static struct { unsigned references[MOST]; size_t count; } lists[128]; /* by their letters */
static char *names[CASES], *settings[CASES];

/* What is run now, for messages, and the environment that the host has meanwhile. */
static const char *name, *run, *where, *now = "start";
static uint64_t hosts;

static void fail(const char *what) {
    static char text[300]; /* written without the C library's buffers: a signal may have interrupted it */
    int length = snprintf(text, sizeof text, "%s, %s, %s, %s: %s\n", name, run, where, now, what);
    if (write(2, text, length) != length) _exit(3);
    _exit(1);
}

static void interrupted(int which) {
    set_environment(DEFAULT);
    fail(which == SIGFPE ? "SIGFPE" : "SIGSEGV");
}

#define CALL(call) (now = #call, CALL_IN(hosts, call, fail("another environment after it")))
/* The same, for the version of this instance; what it returns is part of the results. */
#define BY(two, three) kept((version == 2 ? (int)CALL(two) : (int)CALL(three)))

/* What a run gives, and where it is compared with: the first run writes it. */
static unsigned char expected[1 << 20];
static size_t length, place;
static int is_first, refused, environments;

static void keep(const void *data, size_t size) {
    if (place + size > (is_first ? sizeof expected : length)) fail("more results");
    if (is_first) memcpy(expected + place, data, size);
    else if (memcmp(expected + place, data, size)) fail("other bits");
    place += size;
}
static int kept(int status) {
    keep(&status, sizeof status);
    refused += is_first && status;
    return status;
}

/* What the host does in a callback, in its own environment: here something inexact. */
static void called_back(const char *text, double number) {
    uint64_t found = get_environment();
    set_environment(DEFAULT);
    if (found != hosts) fail("another environment in a callback");
    keep(text, strlen(text));
    keep(&number, sizeof number);
    hosts |= INEXACT;
    set_environment(hosts);
}
static void say2(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status, fmi2String category,
                 fmi2String format, ...) {
    (void)environment, (void)instance, (void)status, (void)category;
    called_back(format, 0.0);
}
static void say3(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category, fmi3String message) {
    (void)environment, (void)status, (void)category;
    called_back(message, 0.0);
}
static void update(fmi3InstanceEnvironment environment, double time, bool set, bool get, bool finished, bool may_end,
                   bool *requested, double *end) {
    const char *before = now;
    double value = 0.0;
    (void)set, (void)get, (void)finished, (void)may_end, (void)end;
    called_back("update", time);
    fmi3Instance c = *(fmi3Instance *)environment;
    kept(CALL(fmi3GetFloat64(c, lists['u'].references, 1, &value, 1)));
    keep(&value, sizeof value);
    *requested = false;
    now = before;
    set_environment(hosts);
}

static void read_all(void *c, int version) {
    static double real[MOST];
    static int integer[MOST];
    static uint64_t count[MOST];
    static bool truth[MOST];
    const unsigned *r = lists['r'].references, *i = lists['i'].references, *b = lists['b'].references;
    size_t nr = lists['r'].count, ni = lists['i'].count, nb = lists['b'].count;
    BY(fmi2GetReal(c, r, nr, real), fmi3GetFloat64(c, r, nr, real, nr));
    keep(real, nr * sizeof *real);
    BY(fmi2GetInteger(c, i, ni, integer), fmi3GetUInt64(c, i, ni, count, ni));
    version == 2 ? keep(integer, ni * sizeof *integer) : keep(count, ni * sizeof *count);
    BY(fmi2GetBoolean(c, b, nb, integer), fmi3GetBoolean(c, b, nb, truth, nb));
    version == 2 ? keep(integer, nb * sizeof *integer) : keep(truth, nb * sizeof *truth);
}

/* Derivatives of all unknowns by all variables of a list together; in FMI 3.0 also of their sum by each. */
static void differentiate(void *c, int version, char by) {
    static double ones[MOST], found[MOST];
    const unsigned *u = lists['u'].references, *k = lists[(int)by].references;
    size_t nu = lists['u'].count, nk = lists[(int)by].count;
    for (int j = 0; j < MOST; j++) ones[j] = 1.0;
    memset(found, 0, sizeof found);
    BY(fmi2GetDirectionalDerivative(c, u, nu, k, nk, ones, found),
       fmi3GetDirectionalDerivative(c, u, nu, k, nk, ones, nk, found, nu));
    keep(found, nu * sizeof *found);
    if (version == 2) return;
    kept(CALL(fmi3GetAdjointDerivative(c, u, nu, k, nk, ones, nu, found, nk)));
    keep(found, nk * sizeof *found);
}

static void save_and_restore(void *c, int version) {
    void *state = NULL;
    size_t size = 0;
    if (BY(fmi2GetFMUstate(c, &state), fmi3GetFMUState(c, &state))) return;
    BY(fmi2SerializedFMUstateSize(c, state, &size), fmi3SerializedFMUStateSize(c, state, &size));
    char *bytes = calloc(size + 1, 1);
    BY(fmi2SerializeFMUstate(c, state, bytes, size), fmi3SerializeFMUState(c, state, (fmi3Byte *)bytes, size));
    keep(bytes, size);
    BY(fmi2DeSerializeFMUstate(c, bytes, size, &state), fmi3DeserializeFMUState(c, (fmi3Byte *)bytes, size, &state));
    BY(fmi2SetFMUstate(c, state), fmi3SetFMUState(c, state));
    BY(fmi2FreeFMUstate(c, &state), fmi3FreeFMUState(c, &state));
    free(bytes);
}

/* Handles events until there are no more, and returns the time of the next one. */
static double handle_events(void *c, int version) {
    fmi2EventInfo info = {.nextEventTime = 0.0};
    bool more = false, end, nominals, values = false, next = false;
    double at = 0.0;
    for (int rounds = 0; rounds < 100; rounds++) {
        if (BY(fmi2NewDiscreteStates(c, &info),
               fmi3UpdateDiscreteStates(c, &more, &end, &nominals, &values, &next, &at)))
            break;
        if (version == 2) {
            more = info.newDiscreteStatesNeeded;
            next = info.nextEventTimeDefined, at = info.nextEventTime;
        }
        keep(&at, sizeof at);
        if (!more) break;
    }
    return next ? at : 1e9;
}

static void cosimulate(void *c, int version) {
    if (version == 3) handle_events(c, version), kept(CALL(fmi3EnterStepMode(c)));
    for (int i = 0; i < STEPS; i++) {
        volatile double time = i * STEP, end = time + STEP, force = 0.3, slope = 2.0;
        const unsigned *k = lists['k'].references;
        int first = 1;
        if (i == 2) BY(fmi2SetReal(c, k, 1, (double *)&force), fmi3SetFloat64(c, k, 1, (double *)&force, 1));
        if (i == 3 && version == 2) kept(CALL(fmi2SetRealInputDerivatives(c, k, 1, &first, (double *)&slope)));
        if (i == 4) save_and_restore(c, version);
        for (int parts = 0; parts < 1000 && time < end; parts++) {
            bool event = false, over, early;
            volatile double rest = end - time, reached = end;
            if (BY(fmi2DoStep(c, time, rest, fmi2True),
                   fmi3DoStep(c, time, rest, true, &event, &over, &early, (double *)&reached)))
                break;
            time = reached;
            if (event) {
                kept(CALL(fmi3EnterEventMode(c)));
                handle_events(c, version);
                kept(CALL(fmi3EnterStepMode(c)));
            }
        }
        read_all(c, version);
    }
    for (int order = 1; order <= 3; order++) {
        static double found[MOST];
        static int orders[MOST];
        const unsigned *u = lists['u'].references;
        size_t nu = lists['u'].count;
        for (size_t j = 0; j < nu; j++) orders[j] = order;
        BY(fmi2GetRealOutputDerivatives(c, u, nu, orders, found),
           fmi3GetOutputDerivatives(c, u, nu, orders, found, nu));
        keep(found, nu * sizeof *found);
    }
    differentiate(c, version, 'k');
}

/* By Euler's method, with events where the FMU wants them: whether that is exact does not matter here. */
static void exchange(void *c, int version) {
    static double x[MOST], dx[MOST], z[MOST];
    size_t nx = lists['n'].references[0], nz = lists['n'].references[1];
    double next = handle_events(c, version);
    if (BY(fmi2EnterContinuousTimeMode(c), fmi3EnterContinuousTimeMode(c))) return;
    BY(fmi2GetNominalsOfContinuousStates(c, x, nx), fmi3GetNominalsOfContinuousStates(c, x, nx));
    keep(x, nx * sizeof *x);
    for (int i = 1; i <= SOLVER_STEPS; i++) {
        int enter = 0, end;
        bool enter3 = false, end3;
        volatile double time = i * SOLVER_STEP;
        BY(fmi2GetContinuousStates(c, x, nx), fmi3GetContinuousStates(c, x, nx));
        BY(fmi2GetDerivatives(c, dx, nx), fmi3GetContinuousStateDerivatives(c, dx, nx));
        for (size_t j = 0; j < nx; j++) x[j] += SOLVER_STEP * dx[j];
        BY(fmi2SetTime(c, time), fmi3SetTime(c, time));
        if (BY(fmi2SetContinuousStates(c, x, nx), fmi3SetContinuousStates(c, x, nx))) break;
        if (BY(fmi2GetEventIndicators(c, z, nz), fmi3GetEventIndicators(c, z, nz))) break;
        keep(z, nz * sizeof *z);
        if (BY(fmi2CompletedIntegratorStep(c, fmi2True, &enter, &end),
               fmi3CompletedIntegratorStep(c, true, &enter3, &end3)))
            break;
        if (enter || enter3 || time >= next) {
            BY(fmi2EnterEventMode(c), fmi3EnterEventMode(c));
            next = handle_events(c, version);
            BY(fmi2EnterContinuousTimeMode(c), fmi3EnterContinuousTimeMode(c));
        }
        if (i % 25 == 0) read_all(c, version);
        if (i == SOLVER_STEPS / 2) save_and_restore(c, version);
    }
    differentiate(c, version, 'k');
}

static void *instance(int version, int exchanged, void **self) {
    static fmi2CallbackFunctions callbacks = {say2, calloc, free, NULL, NULL};
    unsigned *u = lists['u'].references;
    if (version == 2)
        return CALL(fmi2Instantiate("host", exchanged ? fmi2ModelExchange : fmi2CoSimulation, guid, resource_uri,
                                    &callbacks, 0, fmi2True));
    if (exchanged) return CALL(fmi3InstantiateModelExchange("host", token, resource_path, false, true, self, say3));
    return CALL(fmi3InstantiateCoSimulation("host", token, resource_path, false, true, true, true, u, 1, self, say3,
                                            update));
}

static void start_with(void *c, int version, const char *start) {
    char *text = strdup(start), *rest = text;
    for (char *item; (item = strsep(&rest, " "));) {
        char *value;
        unsigned reference = strtoul(item + 2, &value, 10);
        volatile double real = atof(value + 1);
        int choice = (int)real;
        int64_t wide = choice;
        const double *given = (double *)&real;
        if (*item == 'r') BY(fmi2SetReal(c, &reference, 1, given), fmi3SetFloat64(c, &reference, 1, given, 1));
        else BY(fmi2SetInteger(c, &reference, 1, &choice), fmi3SetInt64(c, &reference, 1, &wide, 1));
    }
    free(text);
}

/* A whole life of an instance, twice, with a reset between. What fails ends nothing: the statuses are results. */
static void live(int version, int exchanged, const char *start) {
    static void *c;
    if (!(c = instance(version, exchanged, &c))) fail("no instance");
    for (int life = 0; life < 2; life++) {
        start_with(c, version, start);
        if (version == 2) kept(CALL(fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0)));
        BY(fmi2EnterInitializationMode(c), fmi3EnterInitializationMode(c, false, 0.0, 0.0, false, 0.0));
        if (life == 0) read_all(c, version), differentiate(c, version, 'p');
        BY(fmi2ExitInitializationMode(c), fmi3ExitInitializationMode(c));
        if (life == 0) exchanged ? exchange(c, version) : cosimulate(c, version);
        read_all(c, version);
        BY(fmi2Terminate(c), fmi3Terminate(c));
        BY(fmi2Reset(c), fmi3Reset(c));
    }
    BY((fmi2FreeInstance(c), 0), (fmi3FreeInstance(c), 0));
}

static void *all(void *signal_stack) {
    sigaltstack(signal_stack, NULL); /* of this thread */
    static const char *const runs[] = {"co-simulation of FMI 2.0", "model exchange of FMI 2.0",
                                       "co-simulation of FMI 3.0", "model exchange of FMI 3.0"};
    for (int i = 0; i < CASES && names[i]; i++) {
        refused = 0;
        for (int kind = 0; kind < 4; kind++) {
            for (int e = 0; e < environments; e++) {
                name = names[i], run = runs[kind], where = ENVIRONMENT_NAMES[e];
                is_first = e == 0, place = 0, hosts = host_environment(e);
                live(2 + kind / 2, kind % 2, settings[i]);
                if (is_first) length = place;
                else if (place != length) fail("fewer results");
            }
        }
        if (refused) printf("%s\n", names[i]);
    }
    return NULL;
}

int main(int count, char **arguments) {
    if (count != 8) {
        fprintf(stderr, "usage: environments LIBRARY RESOURCE_URI RESOURCE_PATH GUID TOKEN STACK_BYTES ENVIRONMENTS\n");
        return 1;
    }
    name = run = where = "none";
    void *library = dlopen(arguments[1], RTLD_NOW | RTLD_LOCAL);
    if (!library) fail(dlerror());
    FUNCTIONS(LOAD)
    resource_uri = arguments[2], resource_path = arguments[3], guid = arguments[4], token = arguments[5];
    environments = atoi(arguments[7]);

    static char lines[1 << 20];
    lines[fread(lines, 1, sizeof lines - 1, stdin)] = 0;
    int cases = 0;
    for (char *rest = lines, *line; (line = strsep(&rest, "\n")) && *line;) {
        char *first = strsep(&line, " ");
        if (first[1]) {
            names[cases] = first, settings[cases++] = line;
            continue;
        }
        for (char *item; (item = strsep(&line, " "));)
            lists[(int)*first].references[lists[(int)*first].count++] = strtoul(item, NULL, 10);
    }

    /* Where the stack has overflown, the handler needs another one. */
    static char other[1 << 16];
    stack_t stack = {.ss_sp = other, .ss_size = sizeof other};
    struct sigaction action = {.sa_handler = interrupted, .sa_flags = SA_ONSTACK};
    sigaction(SIGFPE, &action, NULL), sigaction(SIGSEGV, &action, NULL);

    pthread_attr_t attributes;
    pthread_t thread;
    if (pthread_attr_init(&attributes) || pthread_attr_setstacksize(&attributes, atol(arguments[6])) ||
        pthread_create(&thread, &attributes, all, &stack) || pthread_join(thread, NULL))
        fail("no thread");
    return 0;
}
