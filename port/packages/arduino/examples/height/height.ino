/* Height and climb from a barometer (BMP280) and an accelerometer (MPU-6050), 50 times a second. */
#include <kalmanq.h>

const unsigned long dt_ms = 20;
const float dt_s = dt_ms / 1000.0f;
const float barometer_m = 0.11f;        /* BMP280: 1.3 Pa RMS without its filter, 11 cm */
const float accelerometer_m_s2 = 0.03f; /* MPU-6050: 400 ug/sqrt(Hz), 44 Hz; more where motors shake it */
const float offset_m_s2 = 0.8f;         /* MPU-6050: 80 mg on its z axis */
const float wander_m_s2 = 1e-4f;        /* of the offset, a row */

KQ_PROCESS_F32(motion, 3, 1); /* height_m, climb_m_s, offset_m_s2; the accelerometer is a control */
KQ_SENSOR_F32(barometer, 3, 1);
KQ_FILTER_F32(flight, 3);

float noise() { float sum = -6; for (int i = 0; i < 12; i++) sum += random(1001) / 1000.0f; return sum; } /* of sigma 1 */

/* Yours: return bmp.readAltitude(1013.25); */
float read_height_m() { return 120 + barometer_m * noise(); }
/* Yours, upwards, without gravity: return mpu.getAccelerationZ() / 16384.0f * 9.81f - 9.81f; */
float read_acceleration_m_s2() { return 0.3f + accelerometer_m_s2 * noise(); }

void setup()
{
    static const float h = dt_s * dt_s / 2, A[] = {1, dt_s, -h, 0, 1, -dt_s, 0, 0, 1}, B[] = {h, dt_s, 0};
    static const float G[] = {h * accelerometer_m_s2, 0, dt_s * accelerometer_m_s2, 0, 0, wander_m_s2}; /* Q = G G' */
    static const float H[] = {1, 0, 0}, R = barometer_m * barometer_m;
    static const float x0[] = {0, 0, 0}, P0[] = {1e6f, 0, 0, 0, 1, 0, 0, 0, offset_m_s2 * offset_m_s2};
    Serial.begin(115200);
    if (kq_process_init_factor_f32(&motion, A, B, G, 2) || kq_sensor_init_lean_f32(&barometer, H, &R) ||
        kq_filter_init_f32(&flight, x0, P0)) Serial.println("refused");
}

void loop()
{
    const float u = read_acceleration_m_s2(), z = read_height_m();
    if (kq_step_f32(&flight, &motion, &u, &barometer, &z)) Serial.println("refused");
    Serial.print(kq_mean_f32(&flight, 0)); Serial.print(" m "); /* for the Serial Plotter: one line a row */
    Serial.print(kq_mean_f32(&flight, 1)); Serial.println(" m/s");
    static unsigned long due_ms = millis();
    for (due_ms += dt_ms; (long)(due_ms - millis()) > 0;) {} /* dt_ms from row to row, however long one takes */
}
