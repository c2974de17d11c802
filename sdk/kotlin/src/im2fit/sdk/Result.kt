// SPDX-License-Identifier: Apache-2.0
package im2fit.sdk

/** The values of native_poll, in its order. */
internal class Result {
    val longs = LongArray(Native.RESULT_LONGS)
    val floats = FloatArray(Native.RESULT_FLOATS)

    val state: State get() = State.values()[longs[0].toInt()]
    val guidanceSeen: Set<Guidance> get() = bitsOf(longs[2])
    val measured: Boolean get() = longs[5] == 1L

    fun progress(): Progress = Progress(
        state, bitsOf(longs[1]), bitsOf(longs[3]), longs[9], longs[10], longs[11], longs[7].toInt(), longs[8].toInt(),
        if (longs[4] == 1L) joints(DISPLAY_JOINTS) else emptyList(), floats[TURNED], longs[12]
    )

    fun person(size: Size): Person = Person(
        Measurement.values().associateTo(LinkedHashMap()) { it to estimate(3 * it.ordinal) }, floats[FEMALE], estimate(AGE),
        size, Views.values()[longs[6].toInt()], known(CLOTHED), known(EASE), joints(JOINTS),
        bitsOf(longs[13]), bitsOf(longs[14])
    )

    private fun estimate(at: Int) = Estimate(floats[at], floats[at + 1], floats[at + 2])
    private fun known(at: Int): Float? = floats[at].takeUnless { it.isNaN() }
    private fun joints(at: Int): List<Joint> = JointName.values().map {
        val first = at + 4 * it.ordinal
        Joint(it, floats[first], floats[first + 1], floats[first + 2], floats[first + 3])
    }

    private companion object {
        const val AGE = 33
        const val FEMALE = AGE + 3
        const val CLOTHED = FEMALE + 1
        const val EASE = CLOTHED + 1
        const val JOINTS = EASE + 1 + 4 // after the age bands
        const val DISPLAY_JOINTS = JOINTS + 60
        const val TURNED = DISPLAY_JOINTS + 60
    }
}
