/* A host that instantiates, runs and frees many times: nothing may leak or crash.
 *
 * Usage: cycles LIBRARY RESOURCES GUID [CYCLES [KIND]]
 *
 *   LIBRARY    the FMU's binary, such as binaries/linux64/NewtonsCradle.so of the unzipped FMU
 *   RESOURCES  location of its resources, such as file:///tmp/fmu/resources
 *   GUID       as in its modelDescription.xml, with braces
 *   CYCLES     how many times, 2000 if not given
 *   KIND       1 for co-simulation, as if not given; 0 for model exchange, of five balls
 *
 * Build: cc -std=c99 -D_GNU_SOURCE -O1 -g -Wall -Wextra -o cycles tests/hosts/cycles.c -ldl
 * Check: valgrind --leak-check=full --errors-for-leak-kinds=definite --error-exitcode=9 ./cycles ...
 *
 * Says what it did in one line and exits with 0; with 1 and the reason if a call does not answer as it should, with 2
 * if it was called wrongly.
 */
#include <dlfcn.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef void *Component;
typedef struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
} Callbacks;

enum { OK = 0, ERROR = 3, MODEL_EXCHANGE = 0, CO_SIMULATION = 1, STATES = 16, INDICATORS = 8 };

typedef struct {
    int needed, terminate, nominals, values, defined;
    double next;
} EventInfo;

static Component (*instantiate)(const char *, int, const char *, const char *, const Callbacks *, int, int);
static void (*release)(Component);
static int (*set_up)(Component, int, double, double, int, double);
static int (*enter)(Component);
static int (*leave)(Component);
static int (*reset)(Component);
static int (*terminate)(Component);
static int (*step)(Component, double, double, int);
static int (*get_real)(Component, const unsigned[], size_t, double[]);
static int (*set_real)(Component, const unsigned[], size_t, const double[]);
static int (*set_logging)(Component, int, size_t, const char *const[]);
static int (*enter_event)(Component);
static int (*update)(Component, EventInfo *);
static int (*enter_continuous)(Component);
static int (*completed)(Component, int, int *, int *);
static int (*set_time)(Component, double);
static int (*set_states)(Component, const double[], size_t);
static int (*get_states)(Component, double[], size_t);
static int (*get_rates)(Component, double[], size_t);
static int (*get_indicators)(Component, double[], size_t);
static int (*get_nominals)(Component, double[], size_t);
static int (*get_state)(Component, void **);
static int (*set_state)(Component, void *);
static int (*free_state)(Component, void **);

static size_t lines;

static void logger(void *environment, const char *instance, int status, const char *category, const char *format, ...) {
    char text[1000];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    lines += strlen(instance) > 0 && strlen(category) > 0 && strlen(text) > 0 && status >= OK;
    (void)environment;
}

static void expect(int answer, int wanted, const char *what, int cycle) {
    if (answer != wanted) {
        fprintf(stderr, "cycle %d: %s answered %d instead of %d\n", cycle, what, answer, wanted);
        exit(1);
    }
}

static void *symbol(void *library, const char *name) {
    void *found = dlsym(library, name);
    if (!found) {
        fprintf(stderr, "%s\n", dlerror());
        exit(1);
    }
    return found;
}

static void load(const char *path) {
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!library) {
        fprintf(stderr, "%s\n", dlerror());
        exit(1);
    }
    *(void **)&instantiate = symbol(library, "fmi2Instantiate");
    *(void **)&release = symbol(library, "fmi2FreeInstance");
    *(void **)&set_up = symbol(library, "fmi2SetupExperiment");
    *(void **)&enter = symbol(library, "fmi2EnterInitializationMode");
    *(void **)&leave = symbol(library, "fmi2ExitInitializationMode");
    *(void **)&reset = symbol(library, "fmi2Reset");
    *(void **)&terminate = symbol(library, "fmi2Terminate");
    *(void **)&step = symbol(library, "fmi2DoStep");
    *(void **)&get_real = symbol(library, "fmi2GetReal");
    *(void **)&set_real = symbol(library, "fmi2SetReal");
    *(void **)&set_logging = symbol(library, "fmi2SetDebugLogging");
    *(void **)&enter_event = symbol(library, "fmi2EnterEventMode");
    *(void **)&update = symbol(library, "fmi2NewDiscreteStates");
    *(void **)&enter_continuous = symbol(library, "fmi2EnterContinuousTimeMode");
    *(void **)&completed = symbol(library, "fmi2CompletedIntegratorStep");
    *(void **)&set_time = symbol(library, "fmi2SetTime");
    *(void **)&set_states = symbol(library, "fmi2SetContinuousStates");
    *(void **)&get_states = symbol(library, "fmi2GetContinuousStates");
    *(void **)&get_rates = symbol(library, "fmi2GetDerivatives");
    *(void **)&get_indicators = symbol(library, "fmi2GetEventIndicators");
    *(void **)&get_nominals = symbol(library, "fmi2GetNominalsOfContinuousStates");
    *(void **)&get_state = symbol(library, "fmi2GetFMUstate");
    *(void **)&set_state = symbol(library, "fmi2SetFMUstate");
    *(void **)&free_state = symbol(library, "fmi2FreeFMUstate");
}

/* One run of a second and a half: two collisions, refused calls, and every tenth time a reset and half a run more. */
static void run(Component c, int cycle) {
    const unsigned nobody = 0xFFFFFFFFu;
    const char *const categories[] = {"logEvents"};
    double value = 0;
    expect(set_logging(c, 1, 1, categories), OK, "fmi2SetDebugLogging", cycle);
    for (int again = 0; again <= (cycle % 10 == 0); again++) {
        expect(step(c, 0, 0.01, 1), ERROR, "fmi2DoStep before initialization", cycle);
        expect(set_up(c, 1, 1e-4, 0, 0, 0), OK, "fmi2SetupExperiment", cycle);
        expect(enter(c), OK, "fmi2EnterInitializationMode", cycle);
        expect(leave(c), OK, "fmi2ExitInitializationMode", cycle);
        for (int i = 0; i < 150; i++) {
            expect(step(c, i * 0.01, 0.01, 1), OK, "fmi2DoStep", cycle);
        }
        expect(step(c, 1.5, -1, 1), ERROR, "fmi2DoStep backwards", cycle);
        expect(get_real(c, &nobody, 1, &value), ERROR, "fmi2GetReal of nothing", cycle);
        expect(set_real(c, &nobody, 1, &value), ERROR, "fmi2SetReal of nothing", cycle);
        if (cycle % 10 == 0 && again == 0) {
            expect(reset(c), OK, "fmi2Reset", cycle);
        }
    }
    if (cycle % 2 == 0) { /* Others are freed in the middle of the run. */
        expect(terminate(c), OK, "fmi2Terminate", cycle);
    }
}

/* The same by Euler's method with steps of 10 ms and an event after each; every third run goes back to a saved state once. */
static void integrate(Component c, int cycle) {
    const char *const categories[] = {"logEvents"};
    double y[STATES], rates[STATES], indicators[INDICATORS];
    void *saved = NULL;
    EventInfo info;
    int asked, ended;
    expect(set_logging(c, 1, 1, categories), OK, "fmi2SetDebugLogging", cycle);
    expect(get_states(c, y, STATES), ERROR, "fmi2GetContinuousStates before initialization", cycle);
    expect(set_up(c, 1, 1e-4, 0, 0, 0), OK, "fmi2SetupExperiment", cycle);
    expect(enter(c), OK, "fmi2EnterInitializationMode", cycle);
    expect(leave(c), OK, "fmi2ExitInitializationMode", cycle);
    expect(step(c, 0, 0.01, 1), ERROR, "fmi2DoStep in model exchange", cycle);
    for (int i = 0; i <= 150; i++) {
        expect(update(c, &info), OK, "fmi2NewDiscreteStates", cycle);
        expect(enter_continuous(c), OK, "fmi2EnterContinuousTimeMode", cycle);
        expect(get_nominals(c, y, STATES), OK, "fmi2GetNominalsOfContinuousStates", cycle);
        expect(get_states(c, y, STATES), OK, "fmi2GetContinuousStates", cycle);
        expect(get_rates(c, rates, STATES), OK, "fmi2GetDerivatives", cycle);
        expect(get_indicators(c, indicators, INDICATORS), OK, "fmi2GetEventIndicators", cycle);
        expect(get_indicators(c, indicators, 1), ERROR, "fmi2GetEventIndicators of too few", cycle);
        for (int k = 0; k < STATES; k++) {
            y[k] += 0.01 * rates[k];
        }
        expect(set_time(c, (i + 1) * 0.01), OK, "fmi2SetTime", cycle);
        expect(set_states(c, y, STATES), OK, "fmi2SetContinuousStates", cycle);
        expect(completed(c, 1, &asked, &ended), OK, "fmi2CompletedIntegratorStep", cycle);
        if (cycle % 3 == 0 && (i == 60 || i == 90)) {
            expect(saved ? set_state(c, saved) : get_state(c, &saved), OK, "a saved state", cycle);
        }
        expect(enter_event(c), OK, "fmi2EnterEventMode", cycle);
    }
    expect(free_state(c, &saved), OK, "fmi2FreeFMUstate", cycle);
    if (cycle % 2 == 0) {
        expect(terminate(c), OK, "fmi2Terminate", cycle);
    }
}

int main(int argc, char **argv) {
    if (argc < 4 || argc > 6) {
        fprintf(stderr, "usage: %s LIBRARY RESOURCES GUID [CYCLES [KIND]]\n", argv[0]);
        return 2;
    }
    int cycles = argc >= 5 ? atoi(argv[4]) : 2000;
    int kind = argc == 6 ? atoi(argv[5]) : CO_SIMULATION;
    if (cycles < 1) {
        fprintf(stderr, "CYCLES = %s is refused; allowed: 1 or more\n", argv[4]);
        return 2;
    }
    load(argv[1]);
    for (int cycle = 0; cycle < cycles; cycle++) {
        Callbacks callbacks = {logger, calloc, free, NULL, &lines};
        /* Texts and callbacks that are gone after the call. */
        char *name = strdup("cradle"), *guid = strdup(argv[3]), *resources = strdup(argv[2]);
        if (instantiate(name, kind, "{wrong}", resources, &callbacks, 0, 0)) {
            fprintf(stderr, "cycle %d: a wrong GUID was accepted\n", cycle);
            return 1;
        }
        Component c = instantiate(name, kind, guid, resources, &callbacks, 0, 0);
        free(name);
        free(guid);
        free(resources);
        memset(&callbacks, 0, sizeof callbacks);
        if (!c) {
            fprintf(stderr, "cycle %d: fmi2Instantiate answered NULL\n", cycle);
            return 1;
        }
        if (cycle % 7 != 6) { /* Some are freed at once. */
            kind == MODEL_EXCHANGE ? integrate(c, cycle) : run(c, cycle);
        }
        release(c);
    }
    printf("%d cycles, %zu lines logged\n", cycles, lines);
    return lines > 0 ? 0 : 1;
}
