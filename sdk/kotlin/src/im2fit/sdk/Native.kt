// SPDX-License-Identifier: Apache-2.0
package im2fit.sdk

import java.nio.ByteBuffer

/** The functions of jni/, one to one: statuses, and arrays in its order. Loads libim2fit_jni, and libim2fit with it. */
internal object Native {
    const val OK = 0
    const val NOT_MEASURED = -10

    const val NAMES_STATUS = 0
    const val NAMES_STATE = 1
    const val NAMES_GUIDANCE = 2
    const val NAMES_MEASUREMENT = 3
    const val NAMES_UNIT = 4
    const val NAMES_JOINT = 5
    const val NAMES_VIEW = 6

    const val DO_WAIT = 0
    const val DO_FINISH = 1
    const val DO_RESET = 2
    const val DO_NEXT = 3
    const val DO_SELECT_USER = 4

    const val BYTES_JSON = -1
    const val RESULT_LONGS = 15
    const val RESULT_FLOATS = 3 * 11 + 8 * 15 + 6 + 4 + 1
    const val SIZES_MAX = 64
    const val PLACES_MAX = 8
    const val WORN_MAX = 4

    init {
        System.loadLibrary("im2fit_jni")
    }

    @JvmStatic external fun version(): ByteArray
    @JvmStatic external fun lastError(handle: Long): ByteArray?
    @JvmStatic external fun name(list: Int, index: Int): ByteArray?
    @JvmStatic external fun open(
        paths: Array<ByteArray?>, contents: Array<ByteArray?>, fds: IntArray, offsets: LongArray, sizes: LongArray,
        numbers: IntArray, intrinsics: FloatArray, opened: LongArray
    ): Int
    @JvmStatic external fun close(handle: Long)
    @JvmStatic external fun push(
        handle: Long, pixels: ByteBuffer, confidence: ByteBuffer?, numbers: IntArray, longs: LongArray, floats: FloatArray
    ): Int
    @JvmStatic external fun act(handle: Long, what: Int, number: Int): Int
    @JvmStatic external fun poll(handle: Long, longs: LongArray, floats: FloatArray): Int
    @JvmStatic external fun mask(handle: Long, pixels: ByteArray?, longs: LongArray): Int
    @JvmStatic external fun diagnose(
        handle: Long, depth: ShortArray, width: Int, height: Int, numbers: IntArray, unit: FloatArray
    ): ByteArray?
    @JvmStatic external fun guidanceText(bit: Int, language: ByteArray): ByteArray?
    @JvmStatic external fun sizes(
        handle: Long, names: Array<ByteArray?>, probabilities: FloatArray, counted: IntArray
    ): Int
    @JvmStatic external fun tapeCount(): Int
    @JvmStatic external fun tapeWords(index: Int, language: ByteArray, words: Array<ByteArray?>)
    @JvmStatic external fun tape(handle: Long, statuses: IntArray, values: FloatArray, reasons: Array<ByteArray?>): Int
    @JvmStatic external fun mesh(handle: Long, vertices: FloatArray?, triangles: IntArray?, counted: IntArray): Int
    @JvmStatic external fun residual(handle: Long, values: FloatArray): Int
    @JvmStatic external fun setKnown(handle: Long, facts: FloatArray, sex: Int): Int
    @JvmStatic external fun setRegion(handle: Long, region: FloatArray): Int
    @JvmStatic external fun bytes(handle: Long, what: Int, made: Array<ByteArray?>): Int
    @JvmStatic external fun garmentCount(): Int
    @JvmStatic external fun garmentWords(index: Int, language: ByteArray, words: Array<ByteArray?>)
    @JvmStatic external fun fit(
        handle: Long, id: Array<ByteArray?>, sizes: Array<ByteArray?>, places: Array<ByteArray?>, floats: FloatArray,
        verdicts: IntArray, counted: IntArray
    ): Int
    @JvmStatic external fun dressed(
        handle: Long, ids: Array<ByteArray?>, sizes: Array<ByteArray?>, made: Array<ByteArray?>
    ): Int
    @JvmStatic external fun rig(handle: Long, floats: FloatArray, numbers: IntArray): Int
    @JvmStatic external fun models(handle: Long, longs: LongArray, texts: Array<ByteArray?>): Int
    @JvmStatic external fun rigNodes(names: Array<ByteArray?>, parents: IntArray)

    fun text(bytes: ByteArray?): String? = bytes?.let { String(it, Charsets.UTF_8) }
    fun nameOf(list: Int, index: Int): String? = text(name(list, index))
}

/**
 * A call of the library failed.
 *
 * @property status the number of the status, negative: im2fit.h lists them
 * @property statusName its name: "not_found", "corrupt", "invalid_argument", ...
 */
class Im2fitException internal constructor(val status: Int, message: String) : RuntimeException(message) {
    val statusName: String get() = Native.nameOf(Native.NAMES_STATUS, status) ?: "unknown"
}

/** The library's version, "1.0.0". */
fun im2fitVersion(): String = Native.text(Native.version())!!
