// SPDX-License-Identifier: Apache-2.0
package im2fit.sdk

/** A value with its 95 % interval: millimetres, kilograms of weight, years of age. */
data class Estimate(val value: Float, val low: Float, val high: Float)

/** The eleven measurements of the unclothed body in a relaxed standing pose. Order of the C interface's ids. */
enum class Measurement(val unit: String = "mm") {
    STATURE, SLEEVE_LENGTH, LEG_LENGTH, SHOULDER_BREADTH, NECK_GIRTH, SHOULDER_GIRTH, CHEST_GIRTH, WAIST_GIRTH,
    HIP_GIRTH, INSIDE_LEG, WEIGHT("kg");

    /** As in result.json: "chest_girth". */
    val id: String get() = name.toLowerCase(java.util.Locale.ROOT)
}

/**
 * A clothing size.
 *
 * @property best the most probable size
 * @property probabilities of all sizes of the chart, small to large; they sum to 1
 */
data class Size(val best: String, val probabilities: Map<String, Float>)

/**
 * The measured person.
 *
 * @property female probability
 * @property views the sides that were measured
 * @property clothed probability of wearing clothes, from the frames alone; null: not estimated
 * @property clothingEaseMm expected gap between cloth and skin at the trunk; null: not estimated
 * @property joints the mean pose of the measurement
 * @property knownUsed facts of [FitSession.setKnown] that were used
 * @property knownDoubted facts that were not used because they contradict the frames
 */
data class Person(
    val measurements: Map<Measurement, Estimate>, val female: Float, val age: Estimate, val size: Size,
    val views: Views, val clothed: Float?, val clothingEaseMm: Float?, val joints: List<Joint>,
    val knownUsed: Set<KnownFact>, val knownDoubted: Set<KnownFact>
) {
    operator fun get(measurement: Measurement): Estimate = measurements.getValue(measurement)
}

/** How a session ended. */
sealed class Outcome {
    data class Measured(val person: Person) : Outcome()

    /** Too few frames were accepted. [guidance]: all codes of the session. */
    data class NotMeasured(val state: State, val guidance: Set<Guidance>) : Outcome()
}

/** The value of a definition of the tape for the person. */
sealed class TapeValue {
    data class Measured(val estimate: Estimate) : TapeValue()

    /** There is no value: the library never measures it, or this body has no such section. [reason] is a sentence. */
    data class Refused(val reason: String) : TapeValue()
}

/**
 * A definition of the tape (docs/tape.md).
 *
 * @property unit "mm" or "kg"
 * @property iso clause of ISO 8559-1:2017, or ""
 */
data class TapeDefinition(val id: String, val name: String, val unit: String, val iso: String)

/** All definitions of the tape, named in "en", "de", "es", "fr" or "zh". */
fun tapeDefinitions(language: String = "en"): List<TapeDefinition> = (0 until Native.tapeCount()).map { index ->
    val words = arrayOfNulls<ByteArray>(4)
    Native.tapeWords(index, language.toByteArray(), words)
    val (id, unit, iso, name) = words.map { Native.text(it) }
    TapeDefinition(id!!, requireNotNull(name) { "no language '$language'" }, unit!!, iso!!)
}

/** A mesh in mm: [vertices] x y z each, the soles on y = 0; [triangles] three vertex indices each. */
class Mesh(val vertices: FloatArray, val triangles: IntArray)

/** Formats of an avatar. Order of IM2FIT_AVATAR_... */
enum class Avatar { GLB, OBJ, BVH }
