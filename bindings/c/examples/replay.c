/* The whole pipeline from C: samples in, telemetry out. The same text is C99 and C++17, for a host and for a chip.
 *
 * Input: sample period in microseconds and kind of motion, 4 bytes each; then 52 bytes a sample, little-endian: time
 * (8), gyro, accelerometer and magnetometer (3 x 4 each), temperature (4), flags (4). The processor is little-endian.
 */
#include "replay.h"

#include <meerkat_mwd.h>

#define RECORD_SIZE 52

/* All the memory that the library has. */
static uint64_t probe_storage[MWD_PROBE_SIZE / sizeof(uint64_t)];
static uint64_t surveyor_storage[MWD_SURVEYOR_SIZE / sizeof(uint64_t)];

static uint8_t frame[MWD_FRAME_SIZE];
static size_t frame_length = 0;
static uint16_t sequence = 0;

/* A chip without a C library has no string.h. */
static void copy(void *to, const uint8_t *from, size_t bytes) {
    uint8_t *byte = (uint8_t *)to;
    while (bytes-- > 0) {
        *byte++ = *from++;
    }
}

static size_t length(const char *text) {
    size_t bytes = 0;
    while (text[bytes] != '\0') {
        bytes++;
    }
    return bytes;
}

/* Sends the frame that a call has just written. */
static int sent(MwdStatus status) {
    sequence++;
    return status == MWD_STATUS_OK && io_write(frame, frame_length);
}

static void unpack(const uint8_t *record, MwdSample *sample) {
    copy(&sample->t_us, record, 8);
    copy(sample->gyro_rad_s, record + 8, 12);
    copy(sample->accel_m_s2, record + 20, 12);
    copy(sample->mag_ut, record + 32, 12);
    copy(&sample->temperature_c, record + 44, 4);
    copy(&sample->flags, record + 48, 4);
}

int replay(void) {
    MwdProbe *probe;
    MwdSurveyor *surveyor;
    if (mwd_probe_init(probe_storage, sizeof probe_storage, &probe) != MWD_STATUS_OK ||
        mwd_surveyor_init(surveyor_storage, sizeof surveyor_storage, &surveyor) != MWD_STATUS_OK) {
        return 1;
    }

    MwdConfig config;
    char reason[80];
    if (mwd_config_default(&config, MWD_CONFIG_VERSION, sizeof config) != MWD_STATUS_OK ||
        !io_read(&config.sample_period_us, 4) || !io_read(&config.identification_motion, 4)) {
        return 2;
    }
    if (mwd_config_validate(&config, reason, sizeof reason) != MWD_STATUS_OK) {
        io_write(reason, length(reason));
        return 3;
    }
    if (mwd_probe_configure(probe, &config) != MWD_STATUS_OK ||
        mwd_surveyor_configure(surveyor, &config) != MWD_STATUS_OK) {
        return 4;
    }

    static const uint8_t id[MWD_PROBE_ID_SIZE] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};
    if (!sent(mwd_frame_boot(&config, id, sequence, frame, sizeof frame, &frame_length))) {
        return 5;
    }

    uint8_t record[RECORD_SIZE];
    MwdSample sample;
    MwdOutput output;
    MwdWindow window;
    uint32_t number = 0;
    while (io_read(record, sizeof record)) {
        unpack(record, &sample);
        MwdStatus status = mwd_probe_push(probe, &sample, &output);
        if (status < 0) {
            return 6;
        }
        if (status == MWD_STATUS_OK) {
            if (!sent(mwd_frame_output(&output, sequence, frame, sizeof frame, &frame_length))) {
                return 7;
            }
            if (number % 20 == 0 &&
                !sent(mwd_frame_attitude(&output, sequence, frame, sizeof frame, &frame_length))) {
                return 8;
            }
            uint32_t news = 0;
            mwd_surveyor_push(surveyor, probe, &sample, &output, &news);
            if ((news & MWD_SURVEY_STATIONARY) &&
                !sent(mwd_frame_survey(surveyor, MWD_SURVEY_STATIONARY, sequence, frame, sizeof frame,
                                       &frame_length))) {
                return 9;
            }
        }
        /* Spare time: a bounded piece of identification. */
        if (mwd_probe_poll(probe, mwd_probe_poll_budget(probe), &window) == MWD_STATUS_OK &&
            !sent(mwd_frame_window(&window, sample.temperature_c, sequence, frame, sizeof frame, &frame_length))) {
            return 10;
        }
        number++;
    }
    return number > 0 ? 0 : 11;
}
