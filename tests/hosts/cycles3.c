/* A host of FMI 3.0 that instantiates, runs with events and frees many times: nothing may leak or crash.
 *
 * Usage: cycles3 LIBRARY RESOURCES TOKEN N X CLOCK CLOSED [CYCLES]
 *
 *   LIBRARY    the FMU's binary, such as binaries/x86_64-linux/NewtonsCradle.so of the unzipped FMU
 *   RESOURCES  path of its resources, such as /tmp/fmu/resources/
 *   TOKEN      the instantiationToken of its modelDescription.xml
 *   N, ...     value references of n, x, onset.clock and onset.closed
 *   CYCLES     how many times, 2000 if not given
 *
 * Build: cc -std=c99 -D_GNU_SOURCE -O1 -g -Wall -Wextra -o cycles3 tests/hosts/cycles3.c -ldl
 * Check: valgrind --leak-check=full --errors-for-leak-kinds=definite --error-exitcode=9 ./cycles3 ...
 *
 * Says what it did in one line and exits with 0; with 1 and the reason if a call does not answer as it should, with 2
 * if it was called wrongly.
 */
#include <dlfcn.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef void *Instance;
typedef void Logger(void *, int, const char *, const char *);
typedef void Update(void *, double, bool, bool, bool, bool, bool *, double *);

enum { OK = 0, DISCARD = 2, ERROR = 3, MOST = 9, ROUNDS = 15 };

static Instance (*instantiate)(const char *, const char *, const char *, bool, bool, bool, bool, const uint32_t[],
                               size_t, void *, Logger *, Update *);
static void (*release)(Instance);
static int (*configure)(Instance);
static int (*configured)(Instance);
static int (*enter)(Instance, bool, double, double, bool, double);
static int (*leave)(Instance);
static int (*enter_events)(Instance);
static int (*update_events)(Instance, bool *, bool *, bool *, bool *, bool *, double *);
static int (*enter_steps)(Instance);
static int (*step)(Instance, double, double, bool, bool *, bool *, bool *, double *);
static int (*terminate)(Instance);
static int (*reset)(Instance);
static int (*get_reals)(Instance, const uint32_t[], size_t, double[], size_t);
static int (*get_booleans)(Instance, const uint32_t[], size_t, bool[], size_t);
static int (*get_clocks)(Instance, const uint32_t[], size_t, bool[]);
static int (*set_count)(Instance, const uint32_t[], size_t, const uint64_t[], size_t);
static int (*get_state)(Instance, void **);
static int (*set_state)(Instance, void *);
static int (*free_state)(Instance, void **);
static int (*state_size)(Instance, void *, size_t *);
static int (*to_bytes)(Instance, void *, uint8_t[], size_t);
static int (*from_bytes)(Instance, const uint8_t[], size_t, void **);

static uint32_t n, x, clock_of_onsets, closed;
static size_t lines, ticks, calls;

static void log_message(void *environment, int status, const char *category, const char *message) {
    lines += environment == &lines && strlen(category) > 0 && strlen(message) > 0 && status >= OK;
}

static void within(void *environment, double time, bool set, bool get, bool finished, bool may_end, bool *end, double *at) {
    calls += environment == &lines && time >= 0 && set && get && finished;
    *end = may_end && calls % 5 == 0;
    *at = time;
}

static void expect(int answer, int wanted, const char *what, int cycle) {
    if (answer != wanted) {
        fprintf(stderr, "cycle %d: %s answered %d instead of %d\n", cycle, what, answer, wanted);
        exit(1);
    }
}

static void *library;

static void *symbol(const char *name) {
    void *found = dlsym(library, name);
    if (!found) {
        fprintf(stderr, "%s\n", dlerror());
        exit(1);
    }
    return found;
}

static void load(const char *path) {
    library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!library) {
        fprintf(stderr, "%s\n", dlerror());
        exit(1);
    }
    *(void **)&instantiate = symbol("fmi3InstantiateCoSimulation");
    *(void **)&release = symbol("fmi3FreeInstance");
    *(void **)&configure = symbol("fmi3EnterConfigurationMode");
    *(void **)&configured = symbol("fmi3ExitConfigurationMode");
    *(void **)&enter = symbol("fmi3EnterInitializationMode");
    *(void **)&leave = symbol("fmi3ExitInitializationMode");
    *(void **)&enter_events = symbol("fmi3EnterEventMode");
    *(void **)&update_events = symbol("fmi3UpdateDiscreteStates");
    *(void **)&enter_steps = symbol("fmi3EnterStepMode");
    *(void **)&step = symbol("fmi3DoStep");
    *(void **)&terminate = symbol("fmi3Terminate");
    *(void **)&reset = symbol("fmi3Reset");
    *(void **)&get_reals = symbol("fmi3GetFloat64");
    *(void **)&get_booleans = symbol("fmi3GetBoolean");
    *(void **)&get_clocks = symbol("fmi3GetClock");
    *(void **)&set_count = symbol("fmi3SetUInt64");
    *(void **)&get_state = symbol("fmi3GetFMUState");
    *(void **)&set_state = symbol("fmi3SetFMUState");
    *(void **)&free_state = symbol("fmi3FreeFMUState");
    *(void **)&state_size = symbol("fmi3SerializedFMUStateSize");
    *(void **)&to_bytes = symbol("fmi3SerializeFMUState");
    *(void **)&from_bytes = symbol("fmi3DeserializeFMUState");
}

/* All that has happened, one tick after the other. */
static void take_part(Instance c, size_t balls, int cycle) {
    bool again = true, ignored, active, which[MOST];
    double next;
    while (again) {
        expect(get_clocks(c, &clock_of_onsets, 1, &active), OK, "fmi3GetClock", cycle);
        expect(get_booleans(c, &closed, 1, which, balls), OK, "fmi3GetBoolean", cycle);
        ticks += active;
        expect(update_events(c, &again, &ignored, &ignored, &ignored, &ignored, &next), OK, "fmi3UpdateDiscreteStates",
               cycle);
    }
    expect(enter_steps(c), OK, "fmi3EnterStepMode", cycle);
}

/* The state as bytes, and back. */
static void save_and_load(Instance c, int cycle) {
    void *state = NULL, *read = NULL;
    size_t size;
    expect(get_state(c, &state), OK, "fmi3GetFMUState", cycle);
    expect(state_size(c, state, &size), OK, "fmi3SerializedFMUStateSize", cycle);
    uint8_t *bytes = malloc(size);
    expect(to_bytes(c, state, bytes, size), OK, "fmi3SerializeFMUState", cycle);
    expect(from_bytes(c, bytes, size, &read), OK, "fmi3DeserializeFMUState", cycle);
    expect(set_state(c, read), OK, "fmi3SetFMUState", cycle);
    expect(free_state(c, &state), OK, "fmi3FreeFMUState", cycle);
    expect(free_state(c, &read), OK, "fmi3FreeFMUState", cycle);
    free(bytes);
}

/* One run of a second and a half, of as many balls as the host wants; every tenth time a reset and half a run more. */
static void run(Instance c, bool events, int cycle) {
    const uint32_t nobody = 0xFFFFFFFFu;
    double values[MOST];
    for (int again = 0; again <= (cycle % 10 == 0); again++) {
        uint64_t balls = 1 + (unsigned)(cycle + again) % MOST, none = 0;
        expect(configure(c), OK, "fmi3EnterConfigurationMode", cycle);
        expect(set_count(c, &n, 1, &none, 1), DISCARD, "fmi3SetUInt64 of no balls", cycle);
        expect(set_count(c, &n, 1, &balls, 1), OK, "fmi3SetUInt64", cycle);
        expect(configured(c), OK, "fmi3ExitConfigurationMode", cycle);
        expect(enter(c, true, 1e-4, 0, false, 0), OK, "fmi3EnterInitializationMode", cycle);
        expect(leave(c), OK, "fmi3ExitInitializationMode", cycle);
        if (events) {
            take_part(c, balls, cycle);
        }
        double time = 0;
        for (int i = 1; i <= ROUNDS; i++) {
            while (time < 0.1 * i) {
                bool event, end, early;
                expect(step(c, time, 0.1 * i - time, true, &event, &end, &early, &time), OK, "fmi3DoStep", cycle);
                if (event && !events) {
                    expect(ERROR, OK, "fmi3DoStep: an event without event mode", cycle);
                } else if (event) {
                    expect(enter_events(c), OK, "fmi3EnterEventMode", cycle);
                    if (cycle % 3 == 0) {
                        save_and_load(c, cycle);
                    }
                    take_part(c, balls, cycle);
                }
            }
            expect(get_reals(c, &x, 1, values, balls), OK, "fmi3GetFloat64", cycle);
        }
        save_and_load(c, cycle);
        if (cycle % 2 == 0) { /* Others are freed in the middle of the run, or after a refused call. */
            expect(terminate(c), OK, "fmi3Terminate", cycle);
        } else if (cycle % 5 == 0) {
            expect(get_reals(c, &nobody, 1, values, 1), ERROR, "fmi3GetFloat64 of nothing", cycle);
            expect(leave(c), ERROR, "fmi3ExitInitializationMode in a run", cycle);
            expect(get_reals(c, &x, 1, values, balls), OK, "fmi3GetFloat64 after a refused call", cycle);
        }
        if (cycle % 10 == 0 && again == 0) {
            expect(reset(c), OK, "fmi3Reset", cycle);
        }
    }
}

int main(int argc, char **argv) {
    if (argc < 8 || argc > 9) {
        fprintf(stderr, "usage: %s LIBRARY RESOURCES TOKEN N X CLOCK CLOSED [CYCLES]\n", argv[0]);
        return 2;
    }
    int cycles = argc == 9 ? atoi(argv[8]) : 2000;
    if (cycles < 1) {
        fprintf(stderr, "CYCLES = %s is refused; allowed: 1 or more\n", argv[8]);
        return 2;
    }
    uint32_t *references[] = {&n, &x, &clock_of_onsets, &closed};
    for (int i = 0; i < 4; i++) {
        *references[i] = (uint32_t)strtoul(argv[4 + i], NULL, 10);
    }
    load(argv[1]);
    for (int cycle = 0; cycle < cycles; cycle++) {
        /* Texts that are gone after the call. */
        char *name = strdup("cradle"), *token = strdup(argv[3]), *resources = strdup(argv[2]);
        bool events = cycle % 3 != 2, early = cycle % 4 < 2;
        Update *update = cycle % 3 != 0 ? within : NULL;
        if (instantiate(name, "{wrong}", resources, false, true, events, early, &x, 1, &lines, log_message, update)) {
            fprintf(stderr, "cycle %d: a wrong token was accepted\n", cycle);
            return 1;
        }
        Instance c = instantiate(name, token, resources, false, true, events, early, &x, 1, &lines, log_message, update);
        free(name);
        free(token);
        free(resources);
        if (!c) {
            fprintf(stderr, "cycle %d: fmi3InstantiateCoSimulation answered NULL\n", cycle);
            return 1;
        }
        if (cycle % 7 != 6) { /* Some are freed at once. */
            run(c, events, cycle);
        }
        release(c);
    }
    printf("%d cycles, %zu ticks, %zu calls within steps, %zu lines logged\n", cycles, ticks, calls, lines);
    return ticks > 0 && calls > 0 && lines > 0 ? 0 : 1;
}
