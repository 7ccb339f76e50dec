/* Creep forces of a wheelset from a table: an FMU for co-simulation by FMI 2.0 and FMI 3.0, without state.
 *
 * Axes x ahead, y to the right, z down, and SI units outside; inside those of the table: x to the right, y up, z ahead,
 * mm, N, kN for the axle load, mrad for the yaw. The table is read from resources/creep-table.bin, which
 * flangeway.tables.table_outputs writes: numbers of type double in the order of `read_table`.
 */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

enum { OK, WARNING, DISCARD, ERROR, FATAL };
enum { TIME, LATERAL, YAW, LOAD, SPEED, ROTATION, LATERAL_VELOCITY, YAW_RATE, FRICTION, FIRST_OUTPUT };
enum { N_OF_SIDE = 9, OUTSIDE = FIRST_OUTPUT + 2 * N_OF_SIDE, CLAMP, N_VARIABLES };
enum { NORMAL, ANGLE, ROLL, RADIUS, X, Y, Z, FREE_AHEAD, FREE_ACROSS, STIFF_AHEAD, STIFF_ACROSS, GYRATION, N_OF_PATCH };

static const double SATURATED = 2.0; /* reduced creepage at which the axis of slip is at 0.5 */
static const double ROUNDED = 0.004; /* distance from the limit of friction within which forces bend into it */
static const double LEAST_SPEED = 0.05; /* m/s; creepages below are slip velocities over it, so that they stay finite */

typedef struct {
    int n[3], m[3], patches; /* points of the axes of positions and of creepages; patches of a side */
    double *axes[3], *creep[3], *smooth[3], *joined, *of_patch, *linear, *rest, *all;
} Table;

typedef void (*Logger)(void *environment, const char *name, int status, const char *category, const char *message);
typedef struct {
    Table table;
    double value[N_VARIABLES];
    int stale, failed, fmi3;
    char name[256], message[512];
    void *environment;
    void *logger;
} Model;

/* ---- table ---------------------------------------------------------------------------------------------------- */

static int read_table(Table *t, const char *path) {
    FILE *file = fopen(path, "rb");
    double head[7];
    if (!file) return 0;
    if (fread(head, sizeof(double), 7, file) != 7) { fclose(file); return 0; }
    size_t positions = 1, cells = 2, creepages = 3, sum = 0;
    for (int k = 0; k < 3; k++) {
        t->n[k] = (int)head[k];
        t->m[k] = (int)head[4 + k];
        positions *= t->n[k];
        cells *= t->n[k] > 1 ? t->n[k] - 1 : 1;
        creepages *= t->m[k];
        sum += 3 * t->n[k] + t->m[k];
    }
    t->patches = (int)head[3];
    size_t rows = positions * 2 * t->patches, total = sum + cells + rows * (N_OF_PATCH + 9 * t->m[0] + creepages);
    double *at = t->all = malloc(total * sizeof(double));
    int whole = at && fread(at, sizeof(double), total, file) == total;
    fclose(file);
    if (!whole) return 0;
    for (int k = 0; k < 3; at += t->n[k++]) t->axes[k] = at;
    for (int k = 0; k < 3; at += t->m[k++]) t->creep[k] = at;
    for (int k = 0; k < 3; at += 2 * t->n[k++]) t->smooth[k] = at; /* of both sides */
    t->joined = at; at += cells;
    t->of_patch = at; at += rows * N_OF_PATCH;
    t->linear = at; at += rows * 9 * t->m[0];
    t->rest = at;
    return 1;
}

/* Index below a value within the axis; `*above` is the weight of the next one. */
static int below(const double *axis, int n, double value, double *above) {
    *above = 0.0;
    if (n == 1) return 0;
    int low = 0, high = n - 1;
    while (high - low > 1) {
        int middle = (low + high) / 2;
        if (axis[middle] <= value) low = middle; else high = middle;
    }
    *above = (value - axis[low]) / (axis[low + 1] - axis[low]);
    return low;
}

/* Numbers of the points of an axis around a value within it, and their weights: `stencil` of creep_table.py.
 * `low`, `high`: whether parabolas give the slopes at the points below and above. */
static int stencil(const double *axis, int n, double value, int low, int high, int *node, double *weight) {
    double above, line[4] = {0}, first[4], second[4];
    int at = below(axis, n, value, &above);
    for (int k = 0; k < 4; k++) {
        node[k] = at - 1 + k < 0 ? 0 : at - 1 + k < n ? at - 1 + k : n - 1;
        weight[k] = k == 1;
    }
    if (n == 1) return 0;
    double h = axis[at + 1] - axis[at], t = above;
    line[1] = -1.0 / h;
    line[2] = 1.0 / h;
    double g = low ? axis[at] - axis[at - 1] : h, f = high ? axis[at + 2] - axis[at + 1] : h;
    double left[4] = {-h / g / (g + h), (h / g - g / h) / (g + h), g / h / (g + h), 0.0};
    double right[4] = {0.0, -f / h / (h + f), (f / h - h / f) / (h + f), h / f / (h + f)};
    for (int k = 0; k < 4; k++) {
        first[k] = low ? left[k] : high ? 2.0 * line[k] - right[k] : line[k];
        second[k] = high ? right[k] : low ? 2.0 * line[k] - left[k] : line[k];
        weight[k] += t * t * (3.0 - 2.0 * t) * h * line[k] + h * t * (1.0 - t) * ((1.0 - t) * first[k] - t * second[k]);
    }
    return at;
}

enum { N_AROUND = 64 };

/* Nodes around a position, their weights for both sides, and whether a side's patches go over into each other there.
 * If not, the eight nearest nodes keep patches of their own, and the weights are parts of the load: over the lateral
 * position without slopes at the ends, linear over yaw and load. */
static void around(const Table *t, const double *position, int *nodes, double (*weights)[N_AROUND], int *joined) {
    int at[3], node[3][4];
    double above[3], each[2][3][4];
    for (int k = 0; k < 3; k++) {
        double low = t->axes[k][0], high = t->axes[k][t->n[k] - 1], value = fmin(fmax(position[k], low), high);
        at[k] = below(t->axes[k], t->n[k], value, &above[k]);
        int next = at[k] + 1 < t->n[k] ? at[k] + 1 : at[k];
        for (int side = 0; side < 2; side++)
            stencil(t->axes[k], t->n[k], value, t->smooth[k][2 * at[k] + side] != 0.0,
                    t->smooth[k][2 * next + side] != 0.0, node[k], each[side][k]);
    }
    int c1 = t->n[1] > 1 ? t->n[1] - 1 : 1, c2 = t->n[2] > 1 ? t->n[2] - 1 : 1;
    for (int side = 0; side < 2; side++) joined[side] = t->joined[2 * ((at[0] * c1 + at[1]) * c2 + at[2]) + side] != 0.0;
    for (int corner = 0; corner < N_AROUND; corner++) {
        int place[3] = {corner >> 4 & 3, corner >> 2 & 3, corner & 3};
        double part = 1.0;
        for (int k = 0; k < 3; k++) {
            double step = k ? above[k] : above[k] * above[k] * (3.0 - 2.0 * above[k]);
            part *= place[k] == 1 ? 1.0 - step : place[k] == 2 ? step : 0.0;
        }
        nodes[corner] = (node[0][place[0]] * t->n[1] + node[1][place[1]]) * t->n[2] + node[2][place[2]];
        for (int side = 0; side < 2; side++)
            weights[side][corner] = !joined[side] ? part
                : each[side][0][place[0]] * each[side][1][place[1]] * each[side][2][place[2]];
    }
}

static void within_cone(double *f) {
    double size = hypot(f[0], f[1]), over = fmin(fmax(size, 1.0 - ROUNDED), 1.0 + ROUNDED) - 1.0 + ROUNDED;
    double factor = size > 0.0 ? (fmin(size, 1.0 + ROUNDED) - over * over / (4.0 * ROUNDED)) / size : 1.0;
    f[0] *= factor;
    f[1] *= factor;
}

typedef struct { int node[3][4]; double weight[3][4], unit[3], factor; } Creep;

/* Points around reduced creepages and their weights; opposite creepages have opposite forces. */
static Creep around_creep(const Table *t, double slip, double spin, double creep) {
    Creep c;
    c.factor = slip;
    if (creep < 0.0) { spin = -spin; creep += 3.14159265358979323846; c.factor = -slip; }
    c.unit[0] = cos(spin) * cos(creep);
    c.unit[1] = cos(spin) * sin(creep);
    c.unit[2] = sin(spin);
    double point[3] = {slip, spin, creep}, above;
    for (int k = 0; k < 3; k++) {
        int at = below(t->creep[k], t->m[k], point[k], &above);
        stencil(t->creep[k], t->m[k], point[k], at > 0, at + 2 < t->m[k], c.node[k], c.weight[k]);
    }
    return c;
}

/* Forces over the limit of friction of one patch at a node: what is linear, and the rest (`ForceAxes.at`). */
static void at_node(const Table *t, size_t row, const Creep *c, double *f) {
    f[0] = f[1] = f[2] = 0.0;
    for (int a = 0; a < 4; a++) {
        size_t slip = row * t->m[0] + c->node[0][a];
        const double *linear = t->linear + 9 * slip;
        for (int k = 0; k < 3; k++)
            for (int d = 0; d < 3; d++) f[k] += c->weight[0][a] * linear[3 * k + d] * c->unit[d];
        for (int b = 0; b < 4; b++) {
            double weight = c->weight[0][a] * c->weight[1][b];
            size_t line = (slip * t->m[1] + c->node[1][b]) * t->m[2];
            for (int d = 0; d < 4; d++) {
                const double *value = t->rest + 3 * (line + c->node[2][d]);
                for (int k = 0; k < 3; k++) f[k] += weight * c->weight[2][d] * value[k];
            }
        }
    }
    for (int k = 0; k < 3; k++) f[k] *= c->factor;
    within_cone(f);
}

/* Outputs of both sides for a wheelset that rolls ahead, in the axes of the table. */
static void evaluate(const Table *t, const double *position, double speed, double rotation, double lateral_velocity,
                     double yaw_rate, double friction, double (*push)[3], double (*moment)[3], double (*sums)[3]) {
    int nodes[N_AROUND], joined[2];
    double weights[2][N_AROUND], yaw = 1e-3 * position[1];
    around(t, position, nodes, weights, joined);
    for (int side = 0; side < 2; side++) {
        double sign = side ? 1.0 : -1.0;
        memset(push[side], 0, 3 * sizeof(double));
        memset(moment[side], 0, 3 * sizeof(double));
        memset(sums[side], 0, 3 * sizeof(double));
        /* one set of patches of all nodes, or one for each */
        for (int set = 0; set < (joined[side] ? t->patches : t->patches * N_AROUND); set++) {
            int number = set % t->patches, own = set / t->patches;
            int first = joined[side] ? 0 : own, end = joined[side] ? N_AROUND : own + 1;
            double p[N_OF_PATCH] = {0}, part = joined[side] ? 1.0 : weights[side][own];
            if (part == 0.0) continue;
            for (int corner = first; corner < end; corner++) {
                double weight = weights[side][corner] / part;
                if (weight == 0.0) continue;
                size_t row = ((size_t)nodes[corner] * 2 + side) * t->patches + number;
                for (int k = 0; k < N_OF_PATCH; k++) p[k] += weight * t->of_patch[row * N_OF_PATCH + k];
            }
            p[NORMAL] *= part;
            p[STIFF_AHEAD] *= part;
            p[STIFF_ACROSS] *= part;
            if (!(p[NORMAL] > 0.0)) continue;
            /* creepages in the right-hand form of the side, as CreepTable.creepages */
            double place[3] = {sign * p[X], p[Y], p[Z]}, axis[3], arm[3], size = 0.0, along_axis = 0.0, slip[3];
            axis[0] = cos(p[ROLL]) * cos(sign * yaw);
            axis[1] = sin(p[ROLL]);
            axis[2] = cos(p[ROLL]) * sin(sign * yaw);
            for (int k = 0; k < 3; k++) along_axis += place[k] * axis[k];
            for (int k = 0; k < 3; k++) { arm[k] = place[k] - axis[k] * along_axis; size += arm[k] * arm[k]; }
            for (int k = 0; k < 3; k++) arm[k] *= p[RADIUS] / sqrt(size);
            double turning = -sign * yaw_rate;
            slip[0] = sign * lateral_velocity + turning * place[2] + rotation * (axis[1] * arm[2] - axis[2] * arm[1]);
            slip[1] = rotation * (axis[2] * arm[0] - axis[0] * arm[2]);
            slip[2] = speed - turning * place[0] + rotation * (axis[0] * arm[1] - axis[1] * arm[0]);
            double sine = sin(p[ANGLE]), cosine = cos(p[ANGLE]), reference = fmax(speed, 1e3 * LEAST_SPEED);
            /* creepages without a force are those of rolling: they fall with the speed, and are none at rest */
            double rolls = speed / reference;
            double ahead = slip[2] / reference, across = (-cosine * slip[0] - sine * slip[1]) / reference;
            double spin = (cosine * (rotation * axis[1] + turning) - sine * rotation * axis[0]) / reference;
            /* reduced creepages */
            double limit = friction * p[NORMAL];
            double u1 = p[STIFF_AHEAD] * (ahead - rolls * p[FREE_AHEAD]);
            double u2 = p[STIFF_ACROSS] * (across - rolls * p[FREE_ACROSS]);
            double u3 = p[STIFF_ACROSS] * p[GYRATION] * spin, plane = hypot(u1, u2), whole = hypot(plane, u3);
            double v = whole / fmax(whole + SATURATED * limit, 1e-300), f[3], total[3] = {0};
            Creep creep = around_creep(t, v, atan2(u3, plane), atan2(u2, u1));
            for (int corner = first; corner < end; corner++) {
                double weight = weights[side][corner] / part;
                if (weight == 0.0) continue;
                size_t row = ((size_t)nodes[corner] * 2 + side) * t->patches + number;
                at_node(t, row, &creep, f);
                for (int k = 0; k < 3; k++) total[k] += weight * f[k];
            }
            total[2] *= p[GYRATION];
            within_cone(total);
            for (int k = 0; k < 3; k++) total[k] *= limit;
            /* forces of the rail on the wheel to the right, up and ahead, and their moments about the axle's middle */
            double force[3];
            force[0] = sign * (-p[NORMAL] * sine - total[1] * cosine);
            force[1] = p[NORMAL] * cosine - total[1] * sine;
            force[2] = total[0];
            for (int k = 0; k < 3; k++) push[side][k] += force[k];
            moment[side][0] += p[Y] * force[2] - p[Z] * force[1] - total[2] * sine;
            moment[side][1] += p[X] * force[2] - p[Z] * force[0] - sign * total[2] * cosine;
            moment[side][2] += p[X] * force[1] - p[Y] * force[0];
            sums[side][0] += p[NORMAL];
            sums[side][1] += total[0];
            sums[side][2] += -sign * total[1];
        }
    }
}

/* ---- model ---------------------------------------------------------------------------------------------------- */

static int report(Model *m, int status, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(m->message, sizeof m->message, format, arguments);
    va_end(arguments);
    if (m->logger && m->fmi3)
        ((void (*)(void *, int, const char *, const char *))m->logger)(m->environment, status, "logStatusError", m->message);
    else if (m->logger)
        ((void (*)(void *, const char *, int, const char *, const char *, ...))m->logger)(
            m->environment, m->name, status, "logStatusError", "%s", m->message);
    return status;
}

static int update(Model *m) {
    const char *axes[3] = {"lateral", "yaw", "load"};
    const double factor[3] = {1e-3, -1e-3, 1e3};
    double *v = m->value, push[2][3], moment[2][3], sums[2][3];
    for (int k = LATERAL; k <= FRICTION; k++)
        if (!isfinite(v[k])) return report(m, ERROR, "input number %d is not finite; give finite numbers", k);
    if (v[LOAD] <= 0.0)
        return report(m, ERROR, "load = %g N: the wheelset has lifted off; the table has loads from %g to %g N", v[LOAD],
                      1e3 * m->table.axes[2][0], 1e3 * m->table.axes[2][m->table.n[2] - 1]);
    if (v[FRICTION] < 0.0) return report(m, ERROR, "friction = %g; give 0 or more", v[FRICTION]);
    /* backwards it is the same wheelset seen in a mirror: yaw, yaw rate, rotation and all along the track change signs */
    double way = v[SPEED] < 0.0 ? -1.0 : 1.0;
    double position[3] = {1e3 * v[LATERAL], -1e3 * way * v[YAW], 1e-3 * v[LOAD]};
    v[OUTSIDE] = 0.0;
    for (int k = 0; k < 3; k++) {
        double low = m->table.axes[k][0], high = m->table.axes[k][m->table.n[k] - 1], slack = 1e-6 * fmax(fabs(high), 1.0);
        if (position[k] >= low - slack && position[k] <= high + slack) continue;
        v[OUTSIDE] = 1.0;
        if (v[CLAMP] == 0.0)
            return report(m, ERROR, "%s = %g is outside of the table, from %g to %g; make a larger table, or set clamp",
                          axes[k], v[LATERAL + k], fmin(low * factor[k], high * factor[k]),
                          fmax(low * factor[k], high * factor[k]));
    }
    evaluate(&m->table, position, 1e3 * fabs(v[SPEED]), way * v[ROTATION], 1e3 * v[LATERAL_VELOCITY], -way * v[YAW_RATE],
             v[FRICTION], push, moment, sums);
    for (int side = 0; side < 2; side++) {
        double *out = v + FIRST_OUTPUT + N_OF_SIDE * side;
        out[0] = way * push[side][2];
        out[1] = push[side][0];
        out[2] = -push[side][1];
        out[3] = -1e-3 * moment[side][2];
        out[4] = -1e-3 * way * moment[side][0];
        out[5] = -1e-3 * way * moment[side][1];
        out[6] = sums[side][0];
        out[7] = way * sums[side][1];
        out[8] = sums[side][2];
    }
    m->stale = 0;
    return OK;
}

static void start(Model *m) {
    const Table *t = &m->table;
    double *v = m->value, middle[3] = {0.0, 0.0, t->axes[2][t->n[2] / 2]}, weights[2][N_AROUND], radius = 0.0, normal = 0.0;
    int nodes[N_AROUND], joined[2];
    for (int k = 0; k < 2; k++) middle[k] = fmin(fmax(0.0, t->axes[k][0]), t->axes[k][t->n[k] - 1]);
    memset(v, 0, sizeof m->value);
    v[LATERAL] = 1e-3 * middle[0];
    v[YAW] = -1e-3 * middle[1];
    v[LOAD] = 1e3 * middle[2];
    v[SPEED] = 20.0;
    v[FRICTION] = 0.3;
    around(t, middle, nodes, weights, joined);
    for (int side = 0; side < 2; side++)
        for (int corner = 0; corner < N_AROUND; corner++)
            for (int number = 0; number < t->patches; number++) {
                size_t row = ((size_t)nodes[corner] * 2 + side) * t->patches + number;
                const double *p = t->of_patch + row * N_OF_PATCH;
                radius += weights[side][corner] * p[NORMAL] * p[RADIUS];
                normal += weights[side][corner] * p[NORMAL];
            }
    v[ROTATION] = v[SPEED] / (1e-3 * radius / normal); /* free rolling */
    m->stale = 1;
}

static Model *instantiate(const char *name, const char *token, const char *resources, void *environment, void *logger,
                          int fmi3) {
    char path[4096];
    Model *m = calloc(1, sizeof(Model));
    if (!m) return NULL;
    m->environment = environment;
    m->logger = logger;
    m->fmi3 = fmi3;
    snprintf(m->name, sizeof m->name, "%s", name ? name : "");
    if (!token || strcmp(token, TOKEN)) {
        report(m, ERROR, "the token %s is not that of this FMU, %s; give the one in modelDescription.xml",
               token ? token : "(none)", TOKEN);
        free(m);
        return NULL;
    }
    if (!resources) resources = "";
    if (!strncmp(resources, "file://", 7)) resources += 7;
#ifdef _WIN32
    if (resources[0] == '/' && resources[1] && resources[2] == ':') resources++;
#endif
    size_t length = 0; /* file addresses have blanks and other letters as %20 */
    for (; *resources && length + 2 < sizeof path; resources++) {
        unsigned code;
        if (!fmi3 && resources[0] == '%' && sscanf(resources + 1, "%2x", &code) == 1) {
            path[length++] = (char)code;
            resources += 2;
        } else path[length++] = *resources;
    }
    path[length] = 0;
    snprintf(path + length, sizeof path - length, "%screep-table.bin",
             length && (path[length - 1] == '/' || path[length - 1] == '\\') ? "" : "/");
    if (!read_table(&m->table, path)) {
        report(m, ERROR, "the table cannot be read: %s", path);
        free(m->table.all);
        free(m);
        return NULL;
    }
    start(m);
    return m;
}

static void release(Model *m) {
    if (!m) return;
    free(m->table.all);
    free(m);
}

static int set_value(Model *m, unsigned reference, double value) {
    if (reference >= N_VARIABLES) return report(m, ERROR, "there is no variable with the reference %u", reference);
    if (reference >= FIRST_OUTPUT && reference != CLAMP) return report(m, ERROR, "variable %u is an output", reference);
    m->value[reference] = value;
    m->stale = 1;
    return OK;
}

static int get_value(Model *m, unsigned reference, double *value) {
    if (reference >= N_VARIABLES) return report(m, ERROR, "there is no variable with the reference %u", reference);
    if (reference >= FIRST_OUTPUT && reference < CLAMP && m->stale && update(m) != OK) return ERROR;
    *value = m->value[reference];
    return OK;
}

static int step(Model *m, double time) {
    m->value[TIME] = time;
    m->stale = 1;
    return update(m); /* outputs at the inputs of now: there is no state */
}

/* ---- FMI 2.0 ---------------------------------------------------------------------------------------------------- */

typedef struct { Logger logger; void *allocate, *release, *finished; void *environment; } Callbacks2;

EXPORT const char *fmi2GetTypesPlatform(void) { return "default"; }
EXPORT const char *fmi2GetVersion(void) { return "2.0"; }
EXPORT void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources,
                             const Callbacks2 *callbacks, int visible, int logging) {
    (void)visible; (void)logging;
    if (type != 1) return NULL; /* co-simulation alone */
    return instantiate(name, guid, resources, callbacks ? callbacks->environment : NULL,
                       callbacks ? (void *)callbacks->logger : NULL, 0);
}
EXPORT void fmi2FreeInstance(void *m) { release(m); }
EXPORT int fmi2SetupExperiment(void *m, int tolerance, double value, double from, int stop, double to) {
    (void)tolerance; (void)value; (void)stop; (void)to;
    ((Model *)m)->value[TIME] = from;
    return OK;
}
EXPORT int fmi2EnterInitializationMode(void *m) { (void)m; return OK; }
EXPORT int fmi2ExitInitializationMode(void *m) { return update(m); }
EXPORT int fmi2Terminate(void *m) { (void)m; return OK; }
EXPORT int fmi2Reset(void *m) { start(m); return OK; }
EXPORT int fmi2SetDebugLogging(void *m, int on, size_t n, const char *const *names) {
    (void)m; (void)on; (void)n; (void)names;
    return OK;
}
EXPORT int fmi2GetReal(void *m, const unsigned *references, size_t n, double *values) {
    for (size_t k = 0; k < n; k++) if (get_value(m, references[k], values + k) != OK) return ERROR;
    return OK;
}
EXPORT int fmi2SetReal(void *m, const unsigned *references, size_t n, const double *values) {
    for (size_t k = 0; k < n; k++) if (set_value(m, references[k], values[k]) != OK) return ERROR;
    return OK;
}
EXPORT int fmi2GetBoolean(void *m, const unsigned *references, size_t n, int *values) {
    double value = 0.0;
    for (size_t k = 0; k < n; k++) {
        if (get_value(m, references[k], &value) != OK) return ERROR;
        values[k] = value != 0.0;
    }
    return OK;
}
EXPORT int fmi2SetBoolean(void *m, const unsigned *references, size_t n, const int *values) {
    for (size_t k = 0; k < n; k++) if (set_value(m, references[k], values[k] != 0) != OK) return ERROR;
    return OK;
}
EXPORT int fmi2DoStep(void *m, double now, double size, int final) { (void)final; return step(m, now + size); }
EXPORT int fmi2CancelStep(void *m) { (void)m; return ERROR; }

/* What a model without state, strings and integers does not have. */
#define NOTHING(name) EXPORT int name(void *m) { (void)m; return ERROR; }
#define NO_VALUES(name) EXPORT int name(void *m, const unsigned *r, size_t n) { (void)m; (void)r; return n ? ERROR : OK; }
NO_VALUES(fmi2GetInteger) NO_VALUES(fmi2SetInteger) NO_VALUES(fmi2GetString) NO_VALUES(fmi2SetString)
NOTHING(fmi2GetFMUstate) NOTHING(fmi2SetFMUstate) NOTHING(fmi2FreeFMUstate) NOTHING(fmi2SerializedFMUstateSize)
NOTHING(fmi2SerializeFMUstate) NOTHING(fmi2DeSerializeFMUstate) NOTHING(fmi2GetDirectionalDerivative)
NOTHING(fmi2SetRealInputDerivatives) NOTHING(fmi2GetRealOutputDerivatives) NOTHING(fmi2GetStatus)
NOTHING(fmi2GetRealStatus) NOTHING(fmi2GetIntegerStatus) NOTHING(fmi2GetBooleanStatus) NOTHING(fmi2GetStringStatus)

/* ---- FMI 3.0 ---------------------------------------------------------------------------------------------------- */

EXPORT const char *fmi3GetVersion(void) { return "3.0"; }
EXPORT void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, _Bool visible,
                                         _Bool logging, _Bool events, _Bool early, const unsigned *intermediate,
                                         size_t n, void *environment, void *logger, void *update_intermediate) {
    (void)visible; (void)logging; (void)events; (void)early; (void)intermediate; (void)n;
    (void)update_intermediate;
    return instantiate(name, token, resources, environment, logger, 1);
}
EXPORT void *fmi3InstantiateModelExchange(void) { return NULL; }
EXPORT void *fmi3InstantiateScheduledExecution(void) { return NULL; }
EXPORT void fmi3FreeInstance(void *m) { release(m); }
EXPORT int fmi3SetDebugLogging(void *m, _Bool on, size_t n, const char *const *names) {
    (void)m; (void)on; (void)n; (void)names;
    return OK;
}
EXPORT int fmi3EnterInitializationMode(void *m, _Bool tolerance, double value, double from, _Bool stop, double to) {
    (void)tolerance; (void)value; (void)stop; (void)to;
    ((Model *)m)->value[TIME] = from;
    return OK;
}
EXPORT int fmi3ExitInitializationMode(void *m) { return update(m); }
EXPORT int fmi3Terminate(void *m) { (void)m; return OK; }
EXPORT int fmi3Reset(void *m) { start(m); return OK; }
EXPORT int fmi3GetFloat64(void *m, const unsigned *references, size_t n, double *values, size_t n_values) {
    return n == n_values ? fmi2GetReal(m, references, n, values) : ERROR;
}
EXPORT int fmi3SetFloat64(void *m, const unsigned *references, size_t n, const double *values, size_t n_values) {
    return n == n_values ? fmi2SetReal(m, references, n, values) : ERROR;
}
EXPORT int fmi3GetBoolean(void *m, const unsigned *references, size_t n, _Bool *values, size_t n_values) {
    double value = 0.0;
    for (size_t k = 0; k < n; k++) {
        if (n != n_values || get_value(m, references[k], &value) != OK) return ERROR;
        values[k] = value != 0.0;
    }
    return OK;
}
EXPORT int fmi3SetBoolean(void *m, const unsigned *references, size_t n, const _Bool *values, size_t n_values) {
    for (size_t k = 0; k < n; k++)
        if (n != n_values || set_value(m, references[k], values[k]) != OK) return ERROR;
    return OK;
}
EXPORT int fmi3DoStep(void *m, double now, double size, _Bool final, _Bool *event, _Bool *stop, _Bool *early,
                      double *last) {
    (void)final;
    *event = *stop = *early = 0;
    *last = now + size;
    return step(m, now + size);
}
NO_VALUES(fmi3GetFloat32) NO_VALUES(fmi3SetFloat32) NO_VALUES(fmi3GetInt8) NO_VALUES(fmi3SetInt8)
NO_VALUES(fmi3GetUInt8) NO_VALUES(fmi3SetUInt8) NO_VALUES(fmi3GetInt16) NO_VALUES(fmi3SetInt16)
NO_VALUES(fmi3GetUInt16) NO_VALUES(fmi3SetUInt16) NO_VALUES(fmi3GetInt32) NO_VALUES(fmi3SetInt32)
NO_VALUES(fmi3GetUInt32) NO_VALUES(fmi3SetUInt32) NO_VALUES(fmi3GetInt64) NO_VALUES(fmi3SetInt64)
NO_VALUES(fmi3GetUInt64) NO_VALUES(fmi3SetUInt64) NO_VALUES(fmi3GetString) NO_VALUES(fmi3SetString)
NO_VALUES(fmi3GetBinary) NO_VALUES(fmi3SetBinary) NO_VALUES(fmi3GetClock) NO_VALUES(fmi3SetClock)
NOTHING(fmi3EnterEventMode) NOTHING(fmi3GetNumberOfVariableDependencies) NOTHING(fmi3GetVariableDependencies)
NOTHING(fmi3GetFMUState) NOTHING(fmi3SetFMUState) NOTHING(fmi3FreeFMUState) NOTHING(fmi3SerializedFMUStateSize)
NOTHING(fmi3SerializeFMUState) NOTHING(fmi3DeserializeFMUState) NOTHING(fmi3GetDirectionalDerivative)
NOTHING(fmi3GetAdjointDerivative) NOTHING(fmi3EnterConfigurationMode) NOTHING(fmi3ExitConfigurationMode)
NOTHING(fmi3GetIntervalDecimal) NOTHING(fmi3GetIntervalFraction) NOTHING(fmi3GetShiftDecimal)
NOTHING(fmi3GetShiftFraction) NOTHING(fmi3SetIntervalDecimal) NOTHING(fmi3SetIntervalFraction)
NOTHING(fmi3SetShiftDecimal) NOTHING(fmi3SetShiftFraction) NOTHING(fmi3EvaluateDiscreteStates)
NOTHING(fmi3UpdateDiscreteStates) NOTHING(fmi3EnterContinuousTimeMode) NOTHING(fmi3CompletedIntegratorStep)
NOTHING(fmi3SetTime) NOTHING(fmi3SetContinuousStates) NOTHING(fmi3GetContinuousStateDerivatives)
NOTHING(fmi3GetEventIndicators) NOTHING(fmi3GetContinuousStates) NOTHING(fmi3GetNominalsOfContinuousStates)
NOTHING(fmi3GetNumberOfEventIndicators) NOTHING(fmi3GetNumberOfContinuousStates) NOTHING(fmi3EnterStepMode)
NOTHING(fmi3GetOutputDerivatives) NOTHING(fmi3ActivateModelPartition)
