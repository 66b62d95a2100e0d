/* A raw copy of `track` while something is attached to it, for suites with track, twin, motion, radar and
   z_of; what must not change is watched by who calls. */
#ifndef KQ_TESTS_COPIES_H
#define KQ_TESTS_COPIES_H

/* The struct alone, with a memory of its own */
static K(filter) copy_of_track(num *memory)
{
    K(filter) copied = track;
    memcpy(memory, track_memory, sizeof track_memory);
    copied.memory = memory;
    ASSERT_OK(K(filter_copy)(&twin, &track));
    return copied;
}

/* It goes on by itself, whatever its first call is, and says so. */
static void assert_copies_go_on_alone(void)
{
    static num memory[FILTER_LEN(2)];
    for (int first = 0; first < 3; first++) {
        K(filter) copied = copy_of_track(memory);
        if (first == 0) {
            ASSERT_OK_UNCHANGED(K(predict)(&copied, &motion, NULL));
            ASSERT_OK(K(predict)(&twin, &motion, NULL));
        } else if (first == 1) {
            ASSERT_OK_UNCHANGED(K(update)(&copied, &radar, z_of(1)));
            ASSERT_OK(K(update)(&twin, &radar, z_of(1)));
        }
        ASSERT_OK_UNCHANGED(K(step)(&copied, &motion, NULL, &radar, z_of(2)));
        ASSERT_OK(K(step)(&twin, &motion, NULL, &radar, z_of(2)));
        TEST_ASSERT_EQUAL_HEX(KQ_EVENT_HISTORY_FULL, K(events)(&copied));
        K(events_clear)(&copied);
        ASSERT_OK_UNCHANGED(K(predict)(&copied, &motion, NULL));
        ASSERT_OK(K(predict)(&twin, &motion, NULL));
        TEST_ASSERT_EQUAL_HEX(0, K(events)(&copied));
        TEST_ASSERT_EQUAL_MEMORY(twin_memory, memory, sizeof memory);
    }
}

#endif
