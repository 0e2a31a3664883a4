/* SUNDIALS CVODES on the benchmark stroke: BDF, dense Jacobian written by hand, sensitivities by its own differences.
   cvode REFERENCE.csv prints the lines of benches/timing.rs. Equations and error norm: fixtures/bench/stroke.rs. */

#include <cvodes/cvodes.h>
#include <math.h>
#include <nvector/nvector_serial.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sundials/sundials_version.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <time.h>

enum { N = 8, POINTS = 2501, SWITCH = 100, MOST = 100 };
static const double SIZE[N] = {10.0, 0.2, 5.0, 5.0, 0.17, 0.07, 0.5, 1.0};
static const double PI = 3.14159265358979323846, K = 47.946330147, LENGTH = 0.17, VOLUME = 1e-5;
#define A1 (PI / 4 * 0.04 * 0.04)
#define A2 (A1 - PI / 4 * 0.02 * 0.02)
#define RELIEF (0.62 * 5e-6 * K)
#define REVERSING (0.62 * 8e-6 * K)
#define SPEED (0.62 * (PI / 4 * 0.0021 * 0.0021) * K)
#define GAP (PI * 0.04 * 2.7e-14 * 1e6 / (12 * 0.03 * 0.03))

typedef struct { double q[6]; double u; } Stroke;

static double solution[POINTS][N];

/* The orifice root, and its slope. */
static double root(double d) { return d / sqrt(sqrt(d * d + 4e-4)); }
static double slope(double d) { double w = d * d + 4e-4; return (w - 0.5 * d * d) / (w * sqrt(sqrt(w))); }
static double clamp(double x) { return fmin(fmax(x, 0.0), 1.0); }

static double stops(double x, double v) {
    double d = fmax(x - LENGTH, 0.0), e = fmax(-x, 0.0);
    return 5e7 * d - 5e7 * e + 5e4 * v * (fmin(1e4 * d, 1.0) + fmin(1e4 * e, 1.0));
}

static int derivative(sunrealtype t, N_Vector state, N_Vector out, void *data) {
    const Stroke *c = data;
    const double *y = N_VGetArrayPointer(state), *q = c->q;
    double *f = N_VGetArrayPointer(out);
    double pp = y[0], zr = y[1], ps = y[2], pa = y[3], x = y[4], v = y[5], pb = y[6], s = y[7], b = 1400 * q[3];
    double qr = zr * RELIEF * root(pp - 0.1), qpa = q[2] * s * REVERSING * root(pp - ps);
    double qo = q[1] * q[1] * SPEED * root(fmin(ps - pa, 0.74)), ql = q[0] * q[0] * q[0] * GAP * (pa - pb);
    double qbt = q[2] * s * REVERSING * root(pb - 0.1);
    (void)t;
    f[0] = b / 5e-5 * (5.5e-3 / 60 - qr - qpa);
    f[1] = (clamp(pp - 10) - zr) / 0.002;
    f[2] = b / 2e-6 * (qpa - qo);
    f[3] = b * (qo - ql - A1 * v) / (VOLUME + A1 * x);
    f[4] = v;
    f[5] = ((pa * A1 - pb * A2) * 1e6 - 2000 * q[4] * v - 3000 * q[5] - stops(x, v)) / 50;
    f[6] = b * (A2 * v + ql - qbt) / (VOLUME + A2 * (LENGTH - x));
    f[7] = (c->u - s) / 0.015;
    return 0;
}

static int jacobian(sunrealtype t, N_Vector state, N_Vector fy, SUNMatrix j, void *data, N_Vector a1, N_Vector a2, N_Vector a3) {
    const Stroke *c = data;
    const double *y = N_VGetArrayPointer(state), *q = c->q;
    double pp = y[0], zr = y[1], ps = y[2], pa = y[3], x = y[4], v = y[5], pb = y[6], s = y[7], b = 1400 * q[3];
    double open = q[2] * REVERSING, orifice = q[1] * q[1] * SPEED, gap = q[0] * q[0] * q[0] * GAP;
    double supply = open * s * slope(pp - ps), through = ps - pa < 0.74 ? orifice * slope(ps - pa) : 0.0;
    double line = b / 5e-5, between = b / 2e-6, va = VOLUME + A1 * x, vb = VOLUME + A2 * (LENGTH - x);
    double qo = orifice * root(fmin(ps - pa, 0.74)), ql = gap * (pa - pb), qbt = open * s * root(pb - 0.1);
    double d = fmax(x - LENGTH, 0.0), e = fmax(-x, 0.0);
    double fx = (d > 0 ? 5e7 + (1e4 * d < 1 ? 5e8 * v : 0) : 0) + (e > 0 ? 5e7 - (1e4 * e < 1 ? 5e8 * v : 0) : 0);
    double fv = 5e4 * (fmin(1e4 * d, 1.0) + fmin(1e4 * e, 1.0));
    (void)t, (void)fy, (void)a1, (void)a2, (void)a3;
#define J(row, column) SM_ELEMENT_D(j, row, column)
    J(0, 0) = -line * (zr * RELIEF * slope(pp - 0.1) + supply);
    J(0, 1) = -line * RELIEF * root(pp - 0.1);
    J(0, 2) = line * supply;
    J(0, 7) = -line * open * root(pp - ps);
    J(1, 0) = pp > 10 && pp < 11 ? 1 / 0.002 : 0;
    J(1, 1) = -1 / 0.002;
    J(2, 0) = between * supply;
    J(2, 2) = -between * (supply + through);
    J(2, 3) = between * through;
    J(2, 7) = between * open * root(pp - ps);
    J(3, 2) = b / va * through;
    J(3, 3) = -b / va * (through + gap);
    J(3, 4) = -b / (va * va) * A1 * (qo - ql - A1 * v);
    J(3, 5) = -b / va * A1;
    J(3, 6) = b / va * gap;
    J(4, 5) = 1;
    J(5, 3) = A1 * 1e6 / 50;
    J(5, 4) = -fx / 50;
    J(5, 5) = -(2000 * q[4] + fv) / 50;
    J(5, 6) = -A2 * 1e6 / 50;
    J(6, 3) = b / vb * gap;
    J(6, 4) = b / (vb * vb) * A2 * (A2 * v + ql - qbt);
    J(6, 5) = b / vb * A2;
    J(6, 6) = -b / vb * (gap + open * s * slope(pb - 0.1));
    J(6, 7) = -b / vb * open * root(pb - 0.1);
    J(7, 7) = -1 / 0.015;
    return 0;
}

static void need(int flag, const char *what) {
    if (flag < 0) {
        fprintf(stderr, "error: %s answers %d\n", what, flag);
        exit(2);
    }
}

/* One stroke with so many sensitivities, into `solution`. */
static void solve(SUNContext context, int count) {
    static const double start[N] = {10.2, 0.2, 2.462, 2.462, 0.02, 0.0, 0.1, 0.0};
    Stroke stroke = {{1, 1, 1, 1, 1, 1}, 0.0};
    sunrealtype scale[6] = {1, 1, 1, 1, 1, 1}, t;
    N_Vector y = N_VNew_Serial(N, context), *slopes = NULL;
    SUNMatrix matrix = SUNDenseMatrix(N, N, context);
    SUNLinearSolver linear = SUNLinSol_Dense(y, matrix, context);
    void *solver = CVodeCreate(CV_BDF, context);
    memcpy(N_VGetArrayPointer(y), start, sizeof start);
    need(CVodeInit(solver, derivative, 0.0, y), "CVodeInit");
    need(CVodeSStolerances(solver, 1e-6, 1e-8), "CVodeSStolerances");
    need(CVodeSetUserData(solver, &stroke), "CVodeSetUserData");
    need(CVodeSetLinearSolver(solver, linear, matrix), "CVodeSetLinearSolver");
    need(CVodeSetJacFn(solver, jacobian), "CVodeSetJacFn");
    need(CVodeSetMaxNumSteps(solver, 100000), "CVodeSetMaxNumSteps");
    if (count > 0) {
        slopes = N_VCloneVectorArray(count, y);
        for (int i = 0; i < count; i++) N_VConst(0.0, slopes[i]);
        need(CVodeSensInit1(solver, count, CV_STAGGERED, NULL, slopes), "CVodeSensInit1");
        need(CVodeSensEEtolerances(solver), "CVodeSensEEtolerances");
        need(CVodeSetSensParams(solver, stroke.q, scale, NULL), "CVodeSetSensParams");
    }
    memcpy(solution[0], start, sizeof start);
    for (int point = 1; point < POINTS; point++) {
        if (point == SWITCH + 1) {
            stroke.u = 1.0;
            need(CVodeReInit(solver, SWITCH * 1e-3, y), "CVodeReInit");
            if (count > 0) need(CVodeSensReInit(solver, CV_STAGGERED, slopes), "CVodeSensReInit");
        }
        if (point == 1 || point == SWITCH + 1)
            need(CVodeSetStopTime(solver, (point == 1 ? SWITCH : POINTS - 1) * 1e-3), "CVodeSetStopTime");
        need(CVode(solver, point * 1e-3, y, &t, CV_NORMAL), "CVode");
        if (count > 0) need(CVodeGetSens(solver, &t, slopes), "CVodeGetSens");
        memcpy(solution[point], N_VGetArrayPointer(y), sizeof solution[point]);
    }
    if (count > 0) N_VDestroyVectorArray(slopes, count);
    CVodeFree(&solver);
    SUNLinSolFree(linear);
    SUNMatDestroy(matrix);
    N_VDestroy(y);
}

/* Root mean square of the error over the points of the reference. */
static double error(const char *path) {
    FILE *file = fopen(path, "r");
    double sum = 0.0, t, y[N];
    int rows = 0;
    if (!file || fscanf(file, "%*[^\n]\n") < 0) {
        fprintf(stderr, "error: cannot read %s\n", path);
        exit(2);
    }
    while (fscanf(file, "%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf", &t, y, y + 1, y + 2, y + 3, y + 4, y + 5, y + 6, y + 7) == 9) {
        const double *found = solution[lround(t * 1e3)];
        for (int i = 0; i < N; i++) sum += pow((found[i] - y[i]) / SIZE[i], 2);
        rows++;
    }
    fclose(file);
    return sqrt(sum / (rows * N));
}

static int by_size(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double milliseconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return now.tv_sec * 1e3 + now.tv_nsec * 1e-6;
}

int main(int count, char **arguments) {
    SUNContext context;
    char version[32] = "";
    if (count != 2) {
        fprintf(stderr, "usage: cvode REFERENCE.csv\n");
        return 2;
    }
#if SUNDIALS_VERSION_MAJOR >= 7
    need(SUNContext_Create(SUN_COMM_NULL, &context), "SUNContext_Create");
#else
    need(SUNContext_Create(NULL, &context), "SUNContext_Create");
#endif
    SUNDIALSGetVersion(version, sizeof version);
    const struct { int sensitivities, runs; const char *what; } tasks[] = {
        {0, 31, "one stroke"}, {3, 11, "3 sensitivities"}, {6, 11, "6 sensitivities"}};
    for (int task = 0; task < 3; task++) {
        double times[MOST];
        for (int i = 0; i < tasks[task].runs; i++) {
            double start = milliseconds();
            solve(context, tasks[task].sensitivities);
            times[i] = milliseconds() - start;
        }
        qsort(times, tasks[task].runs, sizeof *times, by_size);
        printf("%s\tSUNDIALS CVODES\t%.6f\t%.6f\t%.1e, version %s\n", tasks[task].what, times[0],
               times[tasks[task].runs / 2], error(arguments[1]), version);
    }
    SUNContext_Free(&context);
    return 0;
}
