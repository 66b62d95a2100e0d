/*
 * Recorded results: a case is an array of words that holds operations, their inputs, and every bit
 * of their outputs or a digest of it (README.md: the layouts).  Replayed here in freestanding C11, so
 * that the same file runs on the host and in firmware: integers only, no stdio, no heap.
 * What an operation does, q31.c knows of the golden vectors, and floats.c of f32 and f64.
 */
#ifndef KALMANQ_VECTOR_H
#define KALMANQ_VECTOR_H

#include <stddef.h>
#include <stdint.h>

enum { VECTOR_FULL = 1, VECTOR_DIGESTS = 2 }; /* word 0 of a case: its layout */

enum { VECTOR_END = 0 }; /* behind the last operation */

/* What q31's operation "smooth" gives beside mean and sigma */
enum { VECTOR_COVARIANCE = 1, VECTOR_LAG_ONE = 2, VECTOR_NOISE = 4, VECTOR_READING_NOISE = 8 };

/* What a step of the steady-state filter does: both is kq_steady_step */
enum { VECTOR_STEADY_PREDICT = 1, VECTOR_STEADY_UPDATE = 2 };

/* By which update "extended update" takes an innovation */
enum {
    VECTOR_LINEARISED,
    VECTOR_LINEARISED_GATED,
    VECTOR_LINEARISED_HUBER,
    VECTOR_LINEARISED_STUDENT,
    VECTOR_LINEARISED_JUMP
};

/* Inputs of one operation: at least those of a process with n = l = 16, or a model's size */
#if defined(VECTOR_F32) || defined(VECTOR_F64)
enum { VECTOR_INPUTS = 8 };
#else
enum { VECTOR_INPUTS = 1280 };
#endif

/* Words of the history's memory: with the rest about 40 kB of static memory */
enum { VECTOR_HISTORY_WORDS = 4096 };

/* Where what comes out goes: called for every word, in order. */
typedef struct {
    void (*put)(void *to, const char *quantity, int index, int32_t word);
    void *to;
} vector_sink;

/**
 * Carries out one operation on the one filter that there is.
 *   in       `count` words
 * Returns 0, or -1 where the words make no operation: nothing is done then.
 */
int vector_operate(int32_t operation, const int32_t *in, size_t count, const vector_sink *sink);

/** The name of an operation, "?" where there is none. */
const char *vector_name(int32_t operation);

/** Predicts since the last prior */
int vector_steps(void);

/** The digest of a sequence of words: begin with VECTOR_DIGEST_OF_NOTHING, and add every word.
 * FNV-1a, by words instead of bytes. */
#define VECTOR_DIGEST_OF_NOTHING UINT32_C(2166136261)
uint32_t vector_digest(uint32_t digest, int32_t word);

/** The word of the same 32 bits */
int32_t vector_word_of(uint32_t bits);

/* The operation that is replayed, and what differs in it */
typedef struct {
    size_t operation;     /* its number in the case, from 0 */
    int32_t code;         /* which operation */
    int step;             /* predicts up to it, since the last prior */
    const char *quantity; /* NULL: the case cannot be read; "digest": of all its outputs */
    int index;            /* entry of the quantity */
    size_t position;      /* in the case */
    size_t before;        /* outputs of all operations before it */
    int32_t expected, got;
} vector_difference;

/* Sees every output in order, and returns the word that is compared. */
typedef struct {
    int32_t (*see)(void *to, const char *quantity, int index, int32_t word);
    void *to;
} vector_tap;

/**
 * Replays a case.
 *   words       `count` words in flash (flash.h)
 *   tap         NULL for none
 *   difference  out: the operation that is replayed; where the replay ends early, the first difference
 * Returns the number of outputs compared, or 0 at the first difference.
 */
size_t vector_replay(const int32_t *words, size_t count, const vector_tap *tap,
                     vector_difference *difference);

#endif
