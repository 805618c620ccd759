/* A host for Linux and Windows: runs an FMU and prints the values of variables at every communication point, doubles
 * bit by bit, so that platforms can be compared. Halfway it writes the state to the file OWN; at the end it goes back
 * to the state in the file GIVEN, be it this one or that of another platform, and runs the second half again. It has
 * traps for floating-point exceptions, rounds upwards and flushes to zero, which must change nothing and be left alone.
 */

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "environments.h"
#include "fmi2FunctionTypes.h"

#ifdef _WIN32
#include <windows.h>
static void *open_library(const char *path) { return (void *)LoadLibraryA(path); }
static void *find(void *library, const char *name) { return (void *)GetProcAddress((HMODULE)library, name); }
#else
#include <dlfcn.h>
static void *open_library(const char *path) { return dlopen(path, RTLD_NOW | RTLD_LOCAL); }
static void *find(void *library, const char *name) { return dlsym(library, name); }
#endif

/* The functions of the FMU, by their names. */
#define FUNCTIONS(DO) \
    DO(fmi2Instantiate) DO(fmi2SetupExperiment) DO(fmi2EnterInitializationMode) DO(fmi2ExitInitializationMode) \
    DO(fmi2GetReal) DO(fmi2GetInteger) DO(fmi2GetBoolean) DO(fmi2SetReal) DO(fmi2SetInteger) DO(fmi2DoStep) \
    DO(fmi2GetFMUstate) DO(fmi2SetFMUstate) DO(fmi2FreeFMUstate) DO(fmi2SerializedFMUstateSize) \
    DO(fmi2SerializeFMUstate) DO(fmi2DeSerializeFMUstate) DO(fmi2Terminate) DO(fmi2FreeInstance)
#define DECLARE(name) static name##TYPE *name;
#define LOAD(name) if (!(name = (name##TYPE *)find(library, #name))) fail(#name);
FUNCTIONS(DECLARE)

static void fail(const char *what) {
    fprintf(stderr, "%s\n", what);
    exit(1);
}

static uint64_t hosts;
#define CALL(call) CALL_IN(hosts, call, fail("another floating-point environment after " #call))

static void say(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status, fmi2String category,
                fmi2String format, ...) {
    va_list arguments;
    set_environment(DEFAULT);
    (void)environment, (void)instance, (void)status, (void)category;
    va_start(arguments, format);
    vfprintf(stderr, format, arguments);
    va_end(arguments);
    fputc('\n', stderr);
    set_environment(hosts);
}

static void write_state(fmi2Component c, const char *path) {
    fmi2FMUstate state = NULL;
    size_t size = 0;
    if (CALL(fmi2GetFMUstate(c, &state)) || CALL(fmi2SerializedFMUstateSize(c, state, &size)))
        fail("the state was not saved");
    char *bytes = malloc(size);
    if (!bytes || CALL(fmi2SerializeFMUstate(c, state, bytes, size)) || CALL(fmi2FreeFMUstate(c, &state)))
        fail("the state was not serialized");
    FILE *file = fopen(path, "wb");
    if (!file || fwrite(bytes, 1, size, file) != size || fclose(file)) fail("the state was not written");
    free(bytes);
}

static void read_state(fmi2Component c, const char *path) {
    fmi2FMUstate state = NULL;
    static char bytes[1 << 20];
    FILE *file = fopen(path, "rb");
    if (!file) fail("there is no state");
    size_t size = fread(bytes, 1, sizeof bytes, file);
    if (!feof(file) || fclose(file)) fail("the state was not read");
    if (CALL(fmi2DeSerializeFMUstate(c, bytes, size, &state)) || CALL(fmi2SetFMUstate(c, state)) ||
        CALL(fmi2FreeFMUstate(c, &state)))
        fail("the state is refused");
}

int main(int count, char **arguments) {
    if (count < 8)
        fail("usage: outputs LIBRARY RESOURCES GUID STEP STEPS OWN GIVEN [TYPE:REFERENCE=START]... "
             "[TYPE:REFERENCE]...");
    void *library = open_library(arguments[1]);
    if (!library) fail("the library cannot be loaded");
    FUNCTIONS(LOAD)

    fmi2CallbackFunctions callbacks = {say, calloc, free, NULL, NULL};
    double step = atof(arguments[4]);
    long steps = atol(arguments[5]), half = steps / 2;
    hosts = host_environment(ENVIRONMENTS - 1);
    fmi2Component c = CALL(fmi2Instantiate("outputs", fmi2CoSimulation, arguments[3], arguments[2], &callbacks, 0, 0));
    if (!c) fail("no instance");
    int first = 8;
    for (char *start; first < count && (start = strchr(arguments[first], '=')); first++) {
        fmi2ValueReference reference = strtoul(arguments[first] + 2, NULL, 10);
        double real = atof(start + 1);
        int integer = atoi(start + 1);
        if (arguments[first][0] == 'r' ? CALL(fmi2SetReal(c, &reference, 1, &real))
                                       : CALL(fmi2SetInteger(c, &reference, 1, &integer)))
            fail("a start value is refused");
    }
    if (CALL(fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0)) || CALL(fmi2EnterInitializationMode(c)) ||
        CALL(fmi2ExitInitializationMode(c)))
        fail("initialization failed");
    int again = 0;
    for (long i = 0; i <= steps; i++) {
        volatile double time = (double)(i - 1) * step;
        if (i > 0 && CALL(fmi2DoStep(c, time, step, 0))) fail("the step failed");
        for (int k = first; k < count; k++) {
            fmi2ValueReference reference = strtoul(arguments[k] + 2, NULL, 10);
            uint64_t bits = 0;
            double real = 0.0;
            int integer = 0;
            char type = arguments[k][0];
            if (type == 'r'   ? CALL(fmi2GetReal(c, &reference, 1, &real))
                : type == 'i' ? CALL(fmi2GetInteger(c, &reference, 1, &integer))
                              : CALL(fmi2GetBoolean(c, &reference, 1, &integer)))
                fail("reading failed");
            memcpy(&bits, &real, sizeof bits);
            if (type == 'r') printf("%016" PRIx64 " ", bits);
            else printf("%d ", integer);
        }
        printf("\n");
        if (i == half && !again) write_state(c, arguments[6]);
        if (i == steps && !again) {
            read_state(c, arguments[7]);
            again = 1;
            i = half;
        }
    }
    if (CALL(fmi2Terminate(c))) fail("terminate failed");
    CALL((fmi2FreeInstance(c), 0));
    return 0;
}
