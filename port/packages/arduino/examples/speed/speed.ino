/* Speed and acceleration from a GPS (NEO-6M, 1 Hz), 5 times a second, also while there is no fix. */
#include <kalmanq.h>

const unsigned long dt_ms = 200;
const float dt_s = dt_ms / 1000.0f;
const float gps_m_s = 0.15f;  /* NEO-6M: 0.1 m/s for half of the readings, sigma 0.15 */
const float jerk_m_s3 = 1.0f; /* how fast a car's acceleration changes: of white noise, in 1 s by 1 m/s2 */

KQ_PROCESS_F32(motion, 2, 0); /* speed_m_s, acceleration_m_s2 */
KQ_SENSOR_F32(gps, 2, 1);
KQ_FILTER_F32(car, 2);

float noise() { float sum = -6; for (int i = 0; i < 12; i++) sum += random(1001) / 1000.0f; return sum; } /* of sigma 1 */

/* Is there a new fix?  Yours: if (!gps.speed.isUpdated()) return false; *speed_m_s = gps.speed.mps(); return true; */
bool read_speed_m_s(float *speed_m_s)
{
    static int row;
    *speed_m_s = 14 + gps_m_s * noise();
    return ++row % 5 == 0 && (row < 200 || row > 250); /* once a second; a tunnel of 10 s */
}

void setup()
{
    static const float A[] = {1, dt_s, 0, 1}, q = jerk_m_s3 * jerk_m_s3 * dt_s; /* Q of white noise over a row */
    static const float Q[] = {q * dt_s * dt_s / 3, q * dt_s / 2, q * dt_s / 2, q};
    static const float H[] = {1, 0}, R = gps_m_s * gps_m_s, x0[] = {0, 0}, P0[] = {900, 0, 0, 9};
    Serial.begin(115200);
    if (kq_process_init_f32(&motion, A, NULL, Q) || kq_sensor_init_lean_f32(&gps, H, &R) || kq_filter_init_f32(&car, x0, P0)) Serial.println("refused");
}

void loop()
{
    float z;
    kq_status status = kq_predict_f32(&car, &motion, NULL);
    if (!status && read_speed_m_s(&z)) status = kq_update_f32(&car, &gps, &z);
    if (status) Serial.println("refused");
    Serial.print(kq_mean_f32(&car, 0)); Serial.print(" m/s +- "); Serial.println(kq_sigma_f32(&car, 0)); /* wide in the tunnel */
    static unsigned long due_ms = millis();
    for (due_ms += dt_ms; (long)(due_ms - millis()) > 0;) {} /* dt_ms from row to row, however long one takes */
}
