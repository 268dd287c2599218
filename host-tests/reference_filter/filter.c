/* A second implementation of the estimator in float, to hold the library's against:
 * the same equations, none of its code.
 *
 * Forward square-root information filter of the gyro's matrix P and bias b beside the errors of accelerometer and
 * magnetometer, for motion by hand. It is the prototype from which the library's filter was designed, with the terms
 * that were added there since, so that both should agree to rounding:
 *   - the first heading is fixed and the first field free, the start's velocity and position are as wide as their
 *     bounds;
 *   - the curvature of an uncertain rotation in its noise, and of the first attitude in the field's;
 *   - the field's scatter within a node in its noise, and the norm's deviation only as far as that does not explain it;
 *   - norms of single fields, not of their mean;
 *   - what a field that is a mean over a sample period loses in length, in its noise;
 *   - rests judged from nodes that are quiet, read the same and do not turn, and rows that say so of the bias;
 *   - the point at which rows are made linear, which stays until a rest is over;
 *   - nodes that end after half a turn;
 *   - readings of the field that contradict everything known are left out (the library also forgets what they
 *     contradict for 20 s);
 *   - walks of P and b every 10 s, in the place of a fading memory;
 *   - vibration as the mean of its squares;
 *   - P as a turn of what is symmetric, and the heading of a node, in the place of whose change the earth frame turns.
 * Differences from the library: elements of both sensor matrices are unknowns as they are (the library turns them, to
 * the same prior), derivatives are written out, those of P are differences, process noise enters by eliminating it, not
 * by a change of rank one. It knows no gap, no missing reading and no drill string.
 *
 * Node states, 12: attitude error (earth frame), velocity, position, earth field. Globals, 34: magnetometer matrix less
 * its last element (the trace is zero) 8, hard iron 3, magnetometer lag, accelerometer lag, accelerometer matrix 9,
 * b 3, P 9.
 *
 * Standard input, floats in the machine's order: settings (struct settings), then increments (struct increment), to
 * the end.
 * Standard output: the globals' deviations from the prior's mean, their root of information row by row, the prior's
 * mean of b, nodes, nodes at rest, nodes whose field and whose force were left out.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define STATES 12
#define NUISANCES 22
#define GYRO 12
#define GLOBALS (NUISANCES + GYRO)
#define FIRST (2 * STATES)           /* column of the first global */
#define CONSTANT (FIRST + GLOBALS)
#define WIDTH (CONSTANT + 1)
#define ROWS 24                      /* rotation, field, its walk, velocity, position, two bounds, rest */
#define LEFT (ROWS - STATES)

#define NODE_S 0.5f
#define HALF_TURN 3.14159265f
#define START_TILT 0.35f
#define START_HEADING 1e-3f
#define START_FIELD 0.5f
#define REST_RATE 8.7e-4f
#define REST_SPEED 0.01f
#define REST_LEAST_S 0.4f
#define REST_CHANGED 25.0f
#define REST_QUIET 0.5f
#define REST_HELD 0.017f
#define WALK_EVERY_S 10.0f
#define CONTRADICTED 21.1f           /* chi-square of three innovations */

typedef float vector[3];
typedef float matrix[9];

struct settings {
    float gravity, sample_period, increment_s, rest_deviation, most_bias;
    float rotation, rotation_share, field_share, field_at_rest, field_walk, p_walk, bias_walk;
    float position, velocity, velocity_increment, freedom;
    float sigma[GLOBALS];
};

struct increment {
    float seconds;
    vector rate, force, field;
    float vibration;
    vector mean_rate, rate_variance;
};

struct node {
    matrix attitude, linear_at;
    int held;
    float turned;
    vector velocity, position, field;
    int has_field, norms, curved;
    float mean_norm, mean_scatter;
    float root[STATES][STATES + GLOBALS];
};

/* From node to node; derivatives by all globals, zero where a quantity does not depend on them. */
struct path {
    float seconds, angle;
    matrix rotation;
    float rotation_by[3][GYRO];
    vector field, velocity, position;
    float field_by[3][GLOBALS], velocity_by[3][GLOBALS], position_by[3][GLOBALS];
    float norms, vibration;
    vector fields[64];
    int count;
    vector force_read, field_read;
    double rate_sum[3], rate_squares[3], rate_variance[3];
};

struct half {
    int is_there;
    vector rate, variance, mean_variance, force, field;
    float force_variance, field_variance; /* of their directions */
};

static struct settings S;
static struct node node;
static struct path path;
static struct half before, first;
static float first_s, doubted_s;
static vector rest_rate, bias;
static float x[GLOBALS], root[GLOBALS][GLOBALS];
static float fields_out;

static void multiply(const float *a, const float *b, float *product) {
    matrix c;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            c[3 * i + j] = a[3 * i] * b[j] + a[3 * i + 1] * b[3 + j] + a[3 * i + 2] * b[6 + j];
    memcpy(product, c, sizeof c);
}

static void apply(const float *m, const float *v, float *result) {
    vector t;
    for (int i = 0; i < 3; i++) t[i] = m[3 * i] * v[0] + m[3 * i + 1] * v[1] + m[3 * i + 2] * v[2];
    memcpy(result, t, sizeof t);
}

static void cross(const float *a, const float *b, float *result) {
    vector t = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    memcpy(result, t, sizeof t);
}

static float dot(const float *a, const float *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
static float norm(const float *a) { return sqrtf(dot(a, a)); }

static void rotate(const float *v, float *m) {
    float t2 = dot(v, v), t = sqrtf(t2);
    float a = t2 < 1e-4f ? 1 - t2 / 6 : sinf(t) / t, b = t2 < 1e-4f ? 0.5f - t2 / 24 : (1 - cosf(t)) / t2;
    float p = v[0], q = v[1], r = v[2];
    matrix full = {1 - b * (q * q + r * r), b * p * q - a * r,       b * p * r + a * q,
                   b * p * q + a * r,       1 - b * (p * p + r * r), b * q * r - a * p,
                   b * p * r - a * q,       b * q * r + a * p,       1 - b * (p * p + q * q)};
    memcpy(m, full, sizeof full);
}

/* Householder reflection of column `column` of `rows` into the first of them, from there to `width`. */
static void reflect(float **rows, int count, int column, int width) {
    float below = 0;
    for (int i = 1; i < count; i++) below += rows[i][column] * rows[i][column];
    if (below == 0) return;
    float pivot = rows[0][column], alpha = sqrtf(pivot * pivot + below);
    if (pivot > 0) alpha = -alpha;
    float first = pivot - alpha, beta = 1 / (alpha * first);
    for (int c = column + 1; c < width; c++) {
        float sum = first * rows[0][c];
        for (int i = 1; i < count; i++) sum += rows[i][column] * rows[i][c];
        sum *= beta;
        rows[0][c] += sum * first;
        for (int i = 1; i < count; i++) rows[i][c] += sum * rows[i][column];
    }
    rows[0][column] = alpha;
    for (int i = 1; i < count; i++) rows[i][column] = 0;
}

static void start_path(void) {
    memset(&path, 0, sizeof path);
    path.rotation[0] = path.rotation[4] = path.rotation[8] = 1;
}

/* P of its unknowns: exp([a]x) (1 + S), of which [a]x is the antisymmetric part and S the symmetric one. */
static void p_of(const float *d, float *p) {
    vector a = {0.5f * (d[7] - d[5]), 0.5f * (d[2] - d[6]), 0.5f * (d[3] - d[1])};
    matrix turn, stretch;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) stretch[3 * i + j] = (i == j) + 0.5f * (d[3 * i + j] + d[3 * j + i]);
    rotate(a, turn);
    multiply(turn, stretch, p);
}

/* Adds an increment; `force_rate`: derivative of its specific force. */
static void add(const struct increment *it, const float *force_rate) {
    const float *m = x, *iron = x + 8, mag_lag = x[11], accel_lag = x[12], *accel = x + 13;
    float dt = it->seconds;
    matrix p, half, step, middle, middle_p;
    vector raw, rate, t;
    p_of(x + 25, p);
    for (int i = 0; i < 3; i++) raw[i] = it->rate[i] - bias[i] - x[22 + i];
    apply(p, raw, rate);
    for (int i = 0; i < 3; i++) t[i] = 0.5f * dt * rate[i];
    rotate(t, half);
    multiply(half, half, step);
    multiply(path.rotation, half, middle);
    multiply(middle, p, middle_p);
    /* Rotation error at the increment's middle, then at its end. */
    float by[3][GYRO], rate_by[3][GYRO];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            rate_by[i][j] = -middle_p[3 * i + j];
            float d = dt * rate_by[i][j];
            by[i][j] = path.rotation_by[i][j] + 0.5f * d;
            path.rotation_by[i][j] += d;
        }
    for (int k = 0; k < 9; k++) {
        /* A step of 1 %: P's third order is 2e-5 and its rounding 6e-6 of the slope. */
        matrix ahead, behind;
        float d[9];
        memcpy(d, x + 25, sizeof d);
        d[k] += 0.01f;
        p_of(d, ahead);
        d[k] -= 0.02f;
        p_of(d, behind);
        for (int i = 0; i < 9; i++) ahead[i] = (ahead[i] - behind[i]) / 0.02f;
        apply(ahead, raw, t);
        apply(middle, t, t);
        for (int i = 0; i < 3; i++) {
            rate_by[i][3 + k] = t[i];
            by[i][3 + k] = path.rotation_by[i][3 + k] + 0.5f * dt * t[i];
            path.rotation_by[i][3 + k] += dt * t[i];
        }
    }

    /* Field: (1 + M) m + h, which is late by the lag. */
    matrix whole = {m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], -m[0] - m[4]};
    vector corrected, change, field;
    apply(whole, it->field, corrected);
    for (int i = 0; i < 3; i++) corrected[i] += it->field[i] + iron[i];
    cross(corrected, rate, change);
    /* To the second order of the turn within the lag. */
    vector bend, middle_of_lag;
    cross(change, rate, bend);
    for (int i = 0; i < 3; i++) {
        field[i] = corrected[i] + mag_lag * (change[i] + mag_lag / 2 * bend[i]);
        middle_of_lag[i] = corrected[i] + mag_lag / 2 * change[i];
        change[i] += mag_lag * bend[i];
    }
    /* Lag of what matrix and iron add, which is as late as the field. */
    matrix late;
    for (int l = 0; l < 3; l++) {
        vector one = {0}, by_one, bent;
        one[l] = 1;
        cross(one, rate, by_one);
        cross(by_one, rate, bent);
        for (int i = 0; i < 3; i++) by_one[i] = one[i] + mag_lag * (by_one[i] + mag_lag / 2 * bent[i]);
        apply(middle, by_one, by_one);
        for (int i = 0; i < 3; i++) late[3 * i + l] = by_one[i];
    }
    apply(middle, field, field);
    apply(middle, change, change);
    vector turned;
    apply(middle, middle_of_lag, turned);
    if (path.count < 64) memcpy(path.fields[path.count], field, sizeof field);
    path.norms += norm(corrected);
    for (int i = 0; i < 3; i++) {
        path.field[i] += field[i];
        path.field_by[i][11] += change[i];
        for (int j = 0; j < 3; j++) {
            path.field_by[i][8 + j] += late[3 * i + j];
            for (int l = 0; l < 3; l++) {
                float d = late[3 * i + l] * it->field[j];
                if (3 * l + j < 8) path.field_by[i][3 * l + j] += d;
                else { path.field_by[i][0] -= d; path.field_by[i][4] -= d; }
            }
        }
    }
    for (int c = 0; c < GYRO; c++) {
        vector k = {by[0][c], by[1][c], by[2][c]};
        cross(k, field, t);
        for (int i = 0; i < 3; i++) path.field_by[i][NUISANCES + c] += t[i];
        /* Within the lag the field turns by a rate that errs, too. */
        vector errs = {rate_by[0][c], rate_by[1][c], rate_by[2][c]};
        cross(turned, errs, t);
        for (int i = 0; i < 3; i++) path.field_by[i][NUISANCES + c] += mag_lag * t[i];
    }

    /* Specific force: (1 + A) (a + a' lag). */
    vector led, force, force_by_lag;
    float force_by[3][GLOBALS];
    memset(force_by, 0, sizeof force_by);
    for (int i = 0; i < 3; i++) led[i] = it->force[i] + accel_lag * force_rate[i];
    apply(accel, led, force);
    for (int i = 0; i < 3; i++) force[i] += led[i];
    apply(middle, force, force);
    apply(middle, force_rate, force_by_lag);
    for (int i = 0; i < 3; i++) {
        force_by[i][12] = force_by_lag[i];
        for (int l = 0; l < 3; l++)
            for (int j = 0; j < 3; j++) force_by[i][13 + 3 * l + j] = middle[3 * i + l] * led[j];
    }
    for (int c = 0; c < GYRO; c++) {
        vector k = {by[0][c], by[1][c], by[2][c]};
        cross(k, force, t);
        for (int i = 0; i < 3; i++) force_by[i][NUISANCES + c] = t[i];
    }
    for (int i = 0; i < 3; i++) {
        path.position[i] += path.velocity[i] * dt + 0.5f * dt * dt * force[i];
        path.velocity[i] += force[i] * dt;
        for (int c = 0; c < GLOBALS; c++) {
            path.position_by[i][c] += path.velocity_by[i][c] * dt + 0.5f * dt * dt * force_by[i][c];
            path.velocity_by[i][c] += force_by[i][c] * dt;
        }
    }

    multiply(path.rotation, step, path.rotation);
    path.angle += norm(rate) * dt;
    path.seconds += dt;
    path.vibration += it->vibration;
    for (int i = 0; i < 3; i++) {
        path.force_read[i] += it->force[i];
        path.field_read[i] += it->field[i];
        path.rate_sum[i] += it->mean_rate[i];
        path.rate_squares[i] += (double)it->mean_rate[i] * it->mean_rate[i];
        path.rate_variance[i] += it->rate_variance[i];
    }
    path.count++;
}

/* Variance of the mean field on each axis. */
static float field_scatter(void) {
    float n = path.count, scatter = 0;
    for (int k = 0; k < path.count; k++)
        for (int i = 0; i < 3; i++) {
            float d = path.fields[k][i] - path.field[i] / n;
            scatter += d * d;
        }
    return path.count > 1 ? scatter / (n - 1) / (3 * n) : 0;
}

static int turned(const float *a, const float *b, float variance) {
    vector d;
    float na = norm(a), nb = norm(b);
    for (int i = 0; i < 3; i++) d[i] = a[i] / na - b[i] / nb;
    return dot(d, d) > REST_CHANGED * variance;
}

/* A rest is quiet nodes that read the same, whose mean a bias can be, and whose vectors have not turned since the quiet
 * began. */
static int is_rest(void) {
    struct half now, last = before;
    float n = path.count, T = path.seconds, own = S.field_share * S.field_at_rest;
    int quiet = T >= REST_LEAST_S && path.vibration / n < REST_QUIET * REST_QUIET;
    now.is_there = 1;
    for (int i = 0; i < 3; i++) {
        double mean = path.rate_sum[i] / n, between = path.rate_squares[i] / n - mean * mean;
        now.rate[i] = (float)mean;
        now.variance[i] = (float)(path.rate_variance[i] / n + between);
        now.mean_variance[i] = (float)(path.count > 1 ? between / (n - 1) : 0);
        now.force[i] = path.force_read[i];
        now.field[i] = path.field_read[i];
        quiet &= now.variance[i] < S.rest_deviation * S.rest_deviation;
    }
    now.field_variance = own * own + field_scatter() * n * n / dot(now.field, now.field);
    now.force_variance = (S.velocity_increment * S.velocity_increment + path.vibration / n * S.sample_period * T) / (S.gravity * T * S.gravity * T);
    if (!quiet) {
        before.is_there = first.is_there = 0;
        first_s = doubted_s = 0;
        return 0;
    }
    before = now;
    if (!last.is_there) return 0;
    int changed = 0;
    for (int i = 0; i < 3; i++) {
        float d = now.rate[i] - last.rate[i];
        rest_rate[i] = 0.5f * (last.rate[i] + now.rate[i]);
        changed |= d * d > REST_CHANGED * (last.mean_variance[i] + now.mean_variance[i]) + REST_RATE * REST_RATE;
    }
    if (!first.is_there) first = last;
    first_s += T;
    if (turned(first.force, now.force, first.force_variance + now.force_variance)
        || turned(first.field, now.field, first.field_variance + now.field_variance)) {
        doubted_s = first_s;
        first = now;
        first_s = 0;
        return 0;
    }
    /* Beyond the data sheet it is a bias if both vectors would have shown a turn about any axis. */
    vector across;
    cross(now.force, now.field, across);
    float share = norm(across) / (norm(now.force) * norm(now.field)) / 2 * norm(rest_rate) * first_s;
    int shows = share * share > REST_CHANGED * (first.force_variance + now.force_variance + first.field_variance + now.field_variance);
    int usual = 1;
    for (int i = 0; i < 3; i++) usual &= fabsf(rest_rate[i]) < S.most_bias;
    return first_s >= doubted_s && (usual || shows) && !changed;
}

/* The prior: three diagonal elements of the magnetometer matrix whose sum is zero have the precision [2 1; 1 2] /
 * sigma^2 in the first two. */
static void start(void) {
    memcpy(bias, rest_rate, sizeof bias);
    memset(x, 0, sizeof x);
    memset(root, 0, sizeof root);
    for (int i = 0; i < GLOBALS; i++) root[i][i] = 1 / S.sigma[i];
    root[0][0] = sqrtf(2.0f) / S.sigma[0];
    root[0][4] = sqrtf(0.5f) / S.sigma[0];
    root[4][4] = sqrtf(1.5f) / S.sigma[0];

    memset(&node, 0, sizeof node);
    vector up, east;
    float g = norm(path.force_read);
    for (int i = 0; i < 3; i++) up[i] = path.force_read[i] / g;
    int axis = up[0] * up[0] < 0.5f ? 0 : 1;
    for (int i = 0; i < 3; i++) east[i] = (i == axis) - up[axis] * up[i];
    g = norm(east);
    for (int i = 0; i < 3; i++) east[i] /= g;
    memcpy(node.attitude, east, sizeof east);
    cross(up, east, node.attitude + 3);
    memcpy(node.attitude + 6, up, sizeof up);
    node.curved = 20;
    for (int i = 0; i < 3; i++) {
        node.root[i][i] = 1 / (i < 2 ? START_TILT : START_HEADING);
        node.root[3 + i][3 + i] = 1 / S.velocity;
        node.root[6 + i][6 + i] = 1 / S.position;
        node.root[9 + i][9 + i] = 1 / START_FIELD;
    }
}

/* Variance of the node's rotation by what is not known of b and P. */
static float unknown_rotation(void) {
    float sum = 0;
    for (int i = 0; i < 3; i++) {
        float y[GYRO];
        for (int j = 0; j < GYRO; j++) {
            float s = path.rotation_by[i][j];
            for (int k = 0; k < j; k++) s -= root[NUISANCES + k][NUISANCES + j] * y[k];
            y[j] = s / root[NUISANCES + j][NUISANCES + j];
            sum += y[j] * y[j];
        }
    }
    return sum;
}

/* Rows b[0..3] get -w [v]x, or w [v]x, in the attitude's columns. */
static void attitude_rows(float (*b)[WIDTH], const float *v, float w) {
    b[0][1] = -w * v[2]; b[0][2] = w * v[1];
    b[1][0] = w * v[2]; b[1][2] = -w * v[0];
    b[2][0] = -w * v[1]; b[2][1] = w * v[0];
}

static void global_rows(float (*b)[WIDTH], float (*by)[GLOBALS], float w) {
    for (int i = 0; i < 3; i++)
        for (int c = 0; c < GLOBALS; c++) {
            float sum = 0;
            for (int l = 0; l < 3; l++) sum += node.linear_at[3 * i + l] * by[l][c];
            b[i][FIRST + c] = w * sum;
        }
}

static void scale_rows(float (*b)[WIDTH], float by) {
    for (int i = 0; i < 3; i++)
        for (int c = 0; c < WIDTH; c++) b[i][c] *= by;
}

/* Sum of the variances of the attitude's errors about the axes of the earth. */
static float attitude_variance(void) {
    float sum = 0;
    for (int k = 0; k < 3; k++) {
        float y[STATES + GLOBALS];
        for (int j = 0; j < STATES + GLOBALS; j++) {
            float s = j == k;
            for (int i = 0; i < j; i++) s -= (i < STATES ? node.root[i][j] : root[i - STATES][j - STATES]) * y[i];
            y[j] = s / (j < STATES ? node.root[j][j] : root[j - STATES][j - STATES]);
            sum += y[j] * y[j];
        }
    }
    return sum;
}

/* Returns 1 if the constants of three rows on old states and globals are larger than chance makes them: their
 * covariance is that of the unknowns and `noise` times the identity. */
static int contradicted(float (*b)[WIDTH], float noise) {
    float y[3][STATES + GLOBALS], c[3][3];
    for (int k = 0; k < 3; k++)
        for (int j = 0; j < STATES + GLOBALS; j++) {
            float sum = j < STATES ? b[k][j] : b[k][FIRST + j - STATES];
            for (int i = 0; i < j; i++) {
                if (i < STATES) sum -= node.root[i][j] * y[k][i];
                else sum -= root[i - STATES][j - STATES] * y[k][i];
            }
            y[k][j] = sum / (j < STATES ? node.root[j][j] : root[j - STATES][j - STATES]);
        }
    for (int k = 0; k < 3; k++)
        for (int l = 0; l < 3; l++) {
            c[k][l] = k == l ? noise : 0;
            for (int j = 0; j < STATES + GLOBALS; j++) c[k][l] += y[k][j] * y[l][j];
        }
    /* Columns of the adjugate are cross products of the rows. */
    vector e = {b[0][CONSTANT], b[1][CONSTANT], b[2][CONSTANT]}, adjugate[3];
    for (int k = 0; k < 3; k++) cross(c[(k + 1) % 3], c[(k + 2) % 3], adjugate[k]);
    float determinant = dot(c[0], adjugate[0]), chi_square = 0;
    for (int k = 0; k < 3; k++) chi_square += e[k] * dot(adjugate[k], e) / determinant;
    return chi_square > CONTRADICTED;
}

static void update(int rest) {
    static float old[STATES][WIDTH], rows[ROWS][WIDTH];
    float T = path.seconds, nu = S.freedom, w, *r[ROWS + 1];
    memset(old, 0, sizeof old);
    memset(rows, 0, sizeof rows);
    for (int i = 0; i < STATES; i++) {
        memcpy(old[i], node.root[i], STATES * sizeof(float));
        memcpy(old[i] + FIRST, node.root[i] + STATES, GLOBALS * sizeof(float));
    }
    matrix attitude;
    vector dv, dp, velocity, position, mean, innovation, at;
    node.turned = rest ? 0 : node.turned + path.angle;
    if (node.turned > REST_HELD) node.held = 0;
    if (!node.held) memcpy(node.linear_at, node.attitude, sizeof node.linear_at);
    node.held |= rest;
    multiply(node.attitude, path.rotation, attitude);
    apply(node.attitude, path.velocity, dv);
    apply(node.attitude, path.position, dp);
    for (int i = 0; i < 3; i++) {
        float g = i == 2 ? S.gravity : 0;
        velocity[i] = node.velocity[i] + dv[i] - g * T;
        position[i] = node.position[i] + node.velocity[i] * T + dp[i] - 0.5f * g * T * T;
    }

    /* Rotation. */
    float unknown = unknown_rotation(), share = S.rotation_share * path.angle;
    w = sqrtf((nu + 3) / nu / (S.rotation * S.rotation * T + share * share + 0.75f * unknown * unknown));
    for (int i = 0; i < 3; i++) {
        rows[i][i] = -w;
        rows[i][STATES + i] = w;
        for (int c = 0; c < GYRO; c++) {
            float sum = 0;
            for (int l = 0; l < 3; l++) sum += node.linear_at[3 * i + l] * path.rotation_by[l][c];
            rows[i][FIRST + NUISANCES + c] = -w * sum;
        }
    }

    /* Field, and its walk. */
    vector body;
    float n = path.count, scatter = field_scatter();
    for (int i = 0; i < 3; i++) body[i] = path.field[i] / n;
    apply(node.attitude, body, mean);
    if (!node.has_field) memcpy(node.field, mean, sizeof mean);
    node.has_field = 1;
    /* Variance: the sensor's own, and of means that are shorter across the axis by up to angle^2 / 24 of a sample
     * period. */
    float alone = S.field_share * (rest ? S.field_at_rest : 1), turn_of_sample = path.angle / T * S.sample_period;
    float shorter = turn_of_sample * turn_of_sample / 24, own = alone * alone + shorter * shorter;
    for (int i = 0; i < 3; i++) innovation[i] = mean[i] - node.field[i];
    w = 1 / sqrtf(own);
    apply(node.linear_at, body, at);
    attitude_rows(rows + 3, at, -w);
    global_rows(rows + 3, path.field_by, w / n);
    for (int i = 0; i < 3; i++) {
        rows[3 + i][9 + i] = -w;
        rows[3 + i][CONSTANT] = w * innovation[i];
    }
    float usual_scatter = node.norms > 0 ? node.mean_scatter : scatter;
    if (contradicted(rows + 3, (own + usual_scatter) / own)) {
        scale_rows(rows + 3, 0);
        fields_out++;
    } else {
        if (node.norms < 600) node.norms++;
        node.mean_norm += (path.norms / n - node.mean_norm) / node.norms;
        node.mean_scatter += (scatter - node.mean_scatter) / node.norms;
        float deviation = path.norms / n / node.mean_norm - 1, disturbed = deviation * deviation - scatter;
        float variance = own + (disturbed > 0 ? disturbed : 0) + scatter;
        if (node.curved > 0) {
            float turned = attitude_variance(), curvature = turned * turned / 2;
            node.curved = curvature < own ? 0 : node.curved - 1;
            variance += curvature;
        }
        w = sqrtf((nu + 3) / (nu + dot(innovation, innovation) / variance) / variance);
        scale_rows(rows + 3, w * sqrtf(own));
    }
    w = sqrtf((nu + 3) / nu / (((rest ? 0 : S.field_walk * S.field_walk) + 1e-8f) * T));
    for (int i = 0; i < 3; i++) {
        rows[6 + i][9 + i] = -w;
        rows[6 + i][STATES + 9 + i] = w;
    }

    /* Velocity and position go on. */
    float aliased = sqrtf(S.velocity_increment * S.velocity_increment + path.vibration / n * S.sample_period * T);
    float speed = rest ? REST_SPEED : S.velocity;
    w = 1 / aliased;
    apply(node.linear_at, path.velocity, at);
    attitude_rows(rows + 9, at, w);
    global_rows(rows + 9, path.velocity_by, -w);
    for (int i = 0; i < 3; i++) {
        rows[9 + i][3 + i] = -w;
    }
    w = 1 / (0.5f * aliased * T);
    apply(node.linear_at, path.position, at);
    attitude_rows(rows + 12, at, w);
    global_rows(rows + 12, path.position_by, -w);
    for (int i = 0; i < 3; i++) {
        rows[9 + i][STATES + 3 + i] = 1 / aliased;
        rows[12 + i][3 + i] = -w * T;
        rows[12 + i][6 + i] = -w;
        rows[12 + i][STATES + 6 + i] = w;
    }

    /* Their bounds, and what the gyro reads at rest. */
    for (int i = 0; i < 3; i++) {
        rows[15 + i][STATES + 3 + i] = 1 / speed;
        rows[15 + i][CONSTANT] = velocity[i] / speed;
        rows[18 + i][STATES + 6 + i] = 1 / S.position;
        rows[18 + i][CONSTANT] = position[i] / S.position;
        if (rest) {
            rows[21 + i][FIRST + NUISANCES + i] = -1 / REST_RATE;
            rows[21 + i][CONSTANT] = ((float)(path.rate_sum[i] / path.count) - bias[i] - x[NUISANCES + i]) / REST_RATE;
        }
    }

    /* Old states, new states, globals. */
    for (int j = 0; j < STATES; j++) {
        r[0] = old[j];
        for (int i = 0; i < ROWS; i++) r[1 + i] = rows[i];
        reflect(r, ROWS + 1, j, WIDTH);
    }
    for (int j = 0; j < STATES; j++) {
        for (int i = j; i < ROWS; i++) r[i - j] = rows[i];
        reflect(r, ROWS - j, STATES + j, WIDTH);
    }
    float constant[GLOBALS], change[GLOBALS], by[STATES];
    for (int j = 0; j < GLOBALS; j++) {
        float pivot[WIDTH] = {0};
        for (int c = j; c < GLOBALS; c++) pivot[FIRST + c] = root[j][c];
        r[0] = pivot;
        for (int i = 0; i < LEFT; i++) r[1 + i] = rows[STATES + i];
        reflect(r, LEFT + 1, FIRST + j, WIDTH);
        for (int c = j; c < GLOBALS; c++) root[j][c] = pivot[FIRST + c];
        constant[j] = pivot[CONSTANT];
    }
    for (int j = GLOBALS - 1; j >= 0; j--) {
        float sum = -constant[j];
        for (int c = j + 1; c < GLOBALS; c++) sum -= root[j][c] * change[c];
        change[j] = sum / root[j][j];
    }
    for (int j = STATES - 1; j >= 0; j--) {
        float sum = -rows[j][CONSTANT];
        for (int c = 0; c < GLOBALS; c++) sum -= rows[j][FIRST + c] * change[c];
        for (int c = j + 1; c < STATES; c++) sum -= rows[j][STATES + c] * by[c];
        by[j] = sum / rows[j][STATES + j];
        memcpy(node.root[j], rows[j] + STATES, STATES * sizeof(float));
        memcpy(node.root[j] + STATES, rows[j] + FIRST, GLOBALS * sizeof(float));
    }
    float angle = norm(by), most = angle > 0.5f ? 0.5f / angle : 1;
    vector turn = {most * by[0], most * by[1], most * by[2]};
    vector unturned = {0, 0, -turn[2]};
    matrix more, back;
    rotate(turn, more);
    rotate(unturned, back);
    multiply(more, attitude, node.attitude);
    for (int i = 0; i < 3; i++) {
        node.velocity[i] = velocity[i] + by[3 + i];
        node.position[i] = position[i] + by[6 + i];
        node.field[i] += by[9 + i];
    }
    multiply(back, node.attitude, node.attitude);
    apply(back, node.velocity, node.velocity);
    apply(back, node.position, node.position);
    apply(back, node.field, node.field);
    for (int i = 0; i < GLOBALS; i++) x[i] += change[i];
}

/* One global walks: x = x' - q with q of this deviation; q is eliminated, and a triangular root is left. */
static void walk(int global, float deviation) {
    static float rows[GLOBALS + 1][GLOBALS + 1];
    float *r[GLOBALS + 1];
    memset(rows, 0, sizeof rows);
    rows[0][0] = 1 / deviation;
    for (int i = 0; i < GLOBALS; i++) {
        rows[1 + i][0] = -root[i][global];
        for (int c = i; c < GLOBALS; c++) rows[1 + i][1 + c] = root[i][c];
    }
    for (int j = 0; j <= GLOBALS; j++) {
        for (int i = j; i <= GLOBALS; i++) r[i - j] = rows[i];
        reflect(r, GLOBALS + 1 - j, j, GLOBALS + 1);
    }
    for (int i = 0; i < GLOBALS; i++)
        for (int c = i; c < GLOBALS; c++) root[i][c] = rows[1 + i][1 + c];
}

int main(void) {
    size_t room = 1 << 16, count;
    struct increment *all = malloc(room * sizeof *all);
    if (!all || fread(&S, sizeof S, 1, stdin) != 1) return 1;
    count = fread(all, sizeof *all, room, stdin);
    if (count < 2) return 1;
    float unit = norm(all[0].field), unwalked = 0, nodes = 0, rests = 0;
    for (size_t k = 0; k < count; k++)
        for (int i = 0; i < 3; i++) all[k].field[i] /= unit;
    int has_begun = 0;
    start_path();
    /* The last one has no neighbour behind it. */
    for (size_t k = 0; k + 1 < count; k++) {
        vector force_rate;
        for (int i = 0; i < 3; i++)
            force_rate[i] = k > 0 ? (all[k + 1].force[i] - all[k - 1].force[i]) / (2 * all[k].seconds)
                                  : (all[k + 1].force[i] - all[k].force[i]) / all[k].seconds;
        add(&all[k], force_rate);
        if (path.seconds + 0.5f * S.increment_s < NODE_S && path.angle < HALF_TURN) continue;
        int rest = is_rest();
        if (!has_begun && rest) {
            start();
            has_begun = 1;
        } else if (has_begun) {
            unwalked += path.seconds;
            nodes++;
            rests += rest;
            update(rest);
            if (unwalked >= WALK_EVERY_S) {
                for (int i = 0; i < GYRO; i++) walk(NUISANCES + i, sqrtf(unwalked) * (i < 3 ? S.bias_walk : S.p_walk));
                unwalked = 0;
            }
        }
        start_path();
    }
    fwrite(x, sizeof x, 1, stdout);
    fwrite(root, sizeof root, 1, stdout);
    fwrite(bias, sizeof bias, 1, stdout);
    fwrite(&nodes, sizeof nodes, 1, stdout);
    fwrite(&rests, sizeof rests, 1, stdout);
    fwrite(&fields_out, sizeof fields_out, 1, stdout);
    return 0;
}
