// SPDX-License-Identifier: Apache-2.0
package im2fit.sdk

/**
 * Lens distortion, which the library corrects: the Brown-Conrady model of OpenCV, radial [k1] to [k3], tangential [p1] and
 * [p2]. All 0: none.
 */
data class Lens(
    val k1: Float = 0f, val k2: Float = 0f, val k3: Float = 0f, val p1: Float = 0f, val p2: Float = 0f
) {
    companion object {
        /**
         * @param coefficients `CameraCharacteristics.LENS_DISTORTION`, which has this order: k1, k2, k3, p1, p2. Not the
         *   older `LENS_RADIAL_DISTORTION`, which has another model
         */
        @JvmStatic
        fun ofAndroid(coefficients: FloatArray): Lens {
            require(coefficients.size == 5) { "${coefficients.size} coefficients, expected the 5 of LENS_DISTORTION" }
            val (k1, k2, k3, p1, p2) = coefficients
            return Lens(k1, k2, k3, p1, p2)
        }
    }
}

/**
 * The depth camera (not the colour camera), in pixels of frames as delivered, before rotation.
 *
 * @property width pixels, 1..2048
 * @property fx focal lengths and principal point in pixels; the centre of pixel 0 is 0
 * @property rotateDeg 0, 90, 180, 270: clockwise rotation that makes the picture upright
 * @property lens distortion that is not yet corrected
 */
data class CameraModel @JvmOverloads constructor(
    val width: Int, val height: Int, val fx: Float, val fy: Float, val cx: Float, val cy: Float, val rotateDeg: Int = 0,
    val lens: Lens = Lens()
) {
    init {
        require(rotateDeg in listOf(0, 90, 180, 270)) { "rotateDeg is $rotateDeg, expected 0, 90, 180 or 270" }
    }

    /** The pinhole camera of the upright picture. hal/rotate.cpp has the same lines. */
    internal fun upright(): CameraModel = when (rotateDeg) {
        90 -> CameraModel(height, width, fy, fx, height - 1 - cy, cx)
        180 -> CameraModel(width, height, fx, fy, width - 1 - cx, height - 1 - cy)
        270 -> CameraModel(height, width, fy, fx, cy, width - 1 - cx)
        else -> copy(rotateDeg = 0, lens = Lens())
    }
}

/** What the person wears. Order and meaning of IM2FIT_CLOTHING_... */
enum class Clothing {
    /** Estimated from the frames, given a body file. */
    ESTIMATED,
    /** Underwear or close-fitting sportswear. [Guidance.CLOTHED]: more clothes were detected. */
    BARE,
    /** The body under the clothes is measured, with wider intervals. */
    DRESSED
}

/** What is measured in addition to the front. Order of IM2FIT_TURN_... */
enum class Turn {
    /** Nothing. */
    NONE,
    /** The back, after the person has turned it to the camera. */
    BACK,
    /** One slow full turn on the spot. Improves waist, hip and weight most. Needs [Models.body]. */
    AROUND,
    /** The person stands still, and the phone is carried round the person. Each [DepthFrame] needs its pose. */
    WALK
}

/** How the camera senses depth. JUDGED: estimated from the frames. Order of IM2FIT_SENSOR_... */
enum class Sensor { JUDGED, STRUCTURED_LIGHT, TIME_OF_FLIGHT, STEREO }

/**
 * Settings of a session. The defaults are the library's, except [live].
 *
 * @property framesWanted accepted frames until the measurement, 1..1000. With [Turn.BACK]: for each side
 * @property framesMin fewest accepted frames for [FitSession.finish] to measure, 1..framesWanted
 * @property live true: [FitSession.push] drops the oldest frame when the library is behind. False: it waits
 * @property turn what the person is asked to do after the front is accumulated. The guidance requests it
 * @property calibrationPose true: the person raises the arms first
 * @property singleThread true: [FitSession.push] does all work itself
 */
data class Settings(
    val framesWanted: Int = 15, val framesMin: Int = 5, val live: Boolean = true, val turn: Turn = Turn.NONE,
    val clothing: Clothing = Clothing.ESTIMATED, val sensor: Sensor = Sensor.JUDGED,
    val calibrationPose: Boolean = false, val singleThread: Boolean = false
)
