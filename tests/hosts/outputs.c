/* A host for Linux and Windows: runs an FMU and prints the values of variables at every communication point, doubles
 * bit by bit, so that platforms can be compared. Halfway it writes the state to the file OWN; at the end it goes back
 * to the state in the file GIVEN, be it this one or that of another platform, and runs the second half again. */

#include <inttypes.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef _WIN32
#include <windows.h>
static void *open_library(const char *path) { return (void *)LoadLibraryA(path); }
static void *find(void *library, const char *name) { return (void *)GetProcAddress((HMODULE)library, name); }
#else
#include <dlfcn.h>
static void *open_library(const char *path) { return dlopen(path, RTLD_NOW | RTLD_LOCAL); }
static void *find(void *library, const char *name) { return dlsym(library, name); }
#endif

typedef void *Component;
typedef struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
} Callbacks;

static void fail(const char *what) {
    fprintf(stderr, "%s\n", what);
    exit(1);
}

static void say(void *environment, const char *instance, int status, const char *category, const char *format, ...) {
    va_list arguments;
    (void)environment, (void)instance, (void)status, (void)category;
    va_start(arguments, format);
    vfprintf(stderr, format, arguments);
    va_end(arguments);
    fputc('\n', stderr);
}

static void *function(void *library, const char *name) {
    void *found = find(library, name);
    if (!found) fail(name);
    return found;
}

typedef void *State;

static int (*get_state)(Component, State *), (*set_state)(Component, State), (*free_state)(Component, State *);
static int (*size_of_state)(Component, State, size_t *), (*serialize)(Component, State, char *, size_t);
static int (*deserialize)(Component, const char *, size_t, State *);

static void write_state(Component c, const char *path) {
    State state = NULL;
    size_t size = 0;
    if (get_state(c, &state) || size_of_state(c, state, &size)) fail("the state was not saved");
    char *bytes = malloc(size);
    if (!bytes || serialize(c, state, bytes, size) || free_state(c, &state)) fail("the state was not serialized");
    FILE *file = fopen(path, "wb");
    if (!file || fwrite(bytes, 1, size, file) != size || fclose(file)) fail("the state was not written");
    free(bytes);
}

static void read_state(Component c, const char *path) {
    State state = NULL;
    static char bytes[1 << 20];
    FILE *file = fopen(path, "rb");
    if (!file) fail("there is no state");
    size_t size = fread(bytes, 1, sizeof bytes, file);
    if (!feof(file) || fclose(file)) fail("the state was not read");
    if (deserialize(c, bytes, size, &state) || set_state(c, state) || free_state(c, &state))
        fail("the state is refused");
}

int main(int count, char **arguments) {
    if (count < 8)
        fail("usage: outputs LIBRARY RESOURCES GUID STEP STEPS OWN GIVEN [TYPE:REFERENCE=START]... "
             "[TYPE:REFERENCE]...");
    void *library = open_library(arguments[1]);
    if (!library) fail("the library cannot be loaded");
    Component (*instantiate)(const char *, int, const char *, const char *, const Callbacks *, int, int) =
        function(library, "fmi2Instantiate");
    int (*set_up)(Component, int, double, double, int, double) = function(library, "fmi2SetupExperiment");
    int (*enter)(Component) = function(library, "fmi2EnterInitializationMode");
    int (*leave)(Component) = function(library, "fmi2ExitInitializationMode");
    int (*get_real)(Component, const uint32_t *, size_t, double *) = function(library, "fmi2GetReal");
    int (*get_integer)(Component, const uint32_t *, size_t, int *) = function(library, "fmi2GetInteger");
    int (*get_boolean)(Component, const uint32_t *, size_t, int *) = function(library, "fmi2GetBoolean");
    int (*set_real)(Component, const uint32_t *, size_t, const double *) = function(library, "fmi2SetReal");
    int (*set_integer)(Component, const uint32_t *, size_t, const int *) = function(library, "fmi2SetInteger");
    int (*do_step)(Component, double, double, int) = function(library, "fmi2DoStep");
    int (*terminate)(Component) = function(library, "fmi2Terminate");
    void (*release)(Component) = function(library, "fmi2FreeInstance");
    get_state = function(library, "fmi2GetFMUstate");
    set_state = function(library, "fmi2SetFMUstate");
    free_state = function(library, "fmi2FreeFMUstate");
    size_of_state = function(library, "fmi2SerializedFMUstateSize");
    serialize = function(library, "fmi2SerializeFMUstate");
    deserialize = function(library, "fmi2DeSerializeFMUstate");

    Callbacks callbacks = {say, calloc, free, NULL, NULL};
    double step = atof(arguments[4]);
    long steps = atol(arguments[5]), half = steps / 2;
    Component c = instantiate("outputs", 1, arguments[3], arguments[2], &callbacks, 0, 0);
    if (!c) fail("no instance");
    int first = 8;
    for (char *start; first < count && (start = strchr(arguments[first], '=')); first++) {
        uint32_t reference = (uint32_t)strtoul(arguments[first] + 2, NULL, 10);
        double real = atof(start + 1);
        int integer = atoi(start + 1);
        if (arguments[first][0] == 'r' ? set_real(c, &reference, 1, &real) : set_integer(c, &reference, 1, &integer))
            fail("a start value is refused");
    }
    if (set_up(c, 0, 0.0, 0.0, 0, 0.0) || enter(c) || leave(c)) fail("initialization failed");
    int again = 0;
    for (long i = 0; i <= steps; i++) {
        if (i > 0 && do_step(c, (double)(i - 1) * step, step, 0)) fail("the step failed");
        for (int k = first; k < count; k++) {
            uint32_t reference = (uint32_t)strtoul(arguments[k] + 2, NULL, 10);
            uint64_t bits = 0;
            double real = 0.0;
            int integer = 0;
            char type = arguments[k][0];
            if (type == 'r'   ? get_real(c, &reference, 1, &real)
                : type == 'i' ? get_integer(c, &reference, 1, &integer)
                              : get_boolean(c, &reference, 1, &integer))
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
    if (terminate(c)) fail("terminate failed");
    release(c);
    return 0;
}
